/* Numbers that machines are compared by, a name and numbers a line: theta of the network, its values, and light and where it comes from,
 * one position at a time and many at once. What stands before a point in the name says what should be the same.
 *
 *   numbers WEIGHTS.safetensors GRID.safetensors
 *
 * The grid is of 6 x 3 x 6 metres at the origin. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nlg/nlg.h"

enum { kWalls = 16, kPositions = 5000 };

static void print(const char* name, const float* numbers, size_t count) {
  printf("%s", name);
  for (size_t i = 0; i < count; ++i) printf(" %.9g", numbers[i]);
  printf("\n");
}

static int printTheta(const char* path) {
  static uint8_t phi[NLG_SUPPORT_POINT_COUNT], validity[NLG_SUPPORT_POINT_COUNT / 8];
  memset(validity, 255, sizeof validity);
  static float x[NLG_SUPPORT_POINT_COUNT], y[NLG_SUPPORT_POINT_COUNT], z[NLG_SUPPORT_POINT_COUNT], values[NLG_SUPPORT_POINT_COUNT];
  nlg_generator* generator;
  nlg_scratch* scratch;
  const float* points;
  uint64_t pattern_hash;
  char why[256];
  if (nlg_generator_load(path, &generator, why, sizeof why) != NLG_OK) return fprintf(stderr, "%s\n", why), 1;
  if (nlg_support_pattern(&points, &pattern_hash) != NLG_OK || nlg_scratch_create(generator, NULL, &scratch) != NLG_OK) return 1;
  float* theta = malloc(nlg_theta_count(generator) * sizeof(float));
  if (theta == NULL) return 1;
  for (int wall = 0; wall < kWalls; ++wall) {
    for (int p = 0; p < NLG_SUPPORT_POINT_COUNT; ++p) {
      x[p] = points[3 * p], y[p] = points[3 * p + 1], z[p] = points[3 * p + 2];
      const float tent = (1.0f - fabsf(x[p])) * (1.0f - fabsf(y[p])) * (1.0f - fabsf(z[p]));
      phi[p] = x[p] + 0.1f * (float)wall * y[p] < 0.05f * (float)wall ? (uint8_t)lroundf(255.0f * tent) : 0;
    }
    nlg_generate(generator, phi, validity, 1, theta, scratch);
    print("theta", theta, nlg_theta_count(generator));
    nlg_evaluate(generator, theta, NLG_SUPPORT_POINT_COUNT, x, y, z, values, scratch);
    print("value", values, NLG_SUPPORT_POINT_COUNT);
  }
  free(theta);
  nlg_scratch_free(scratch);
  nlg_generator_free(generator);
  return 0;
}

static int printLight(const char* path) {
  static double positions_m[3 * kPositions];
  static float normals[3 * kPositions], rgb[3 * kPositions], status_of_one[kPositions], status_of_all[kPositions];
  static uint8_t status[kPositions];
  nlg_light_grid* grid;
  nlg_look_up_scratch* scratch;
  char why[256];
  if (nlg_light_grid_load(path, &grid, why, sizeof why) != NLG_OK) return fprintf(stderr, "%s\n", why), 1;
  if (nlg_look_up_scratch_create(&scratch) != NLG_OK) return 1;
  for (int i = 0; i < kPositions; ++i) {
    /* all over the room, by three irrational steps; axes in turn */
    positions_m[3 * i] = 6.0 * fmod(0.8191725133961645 * i, 1.0);
    positions_m[3 * i + 1] = 3.0 * fmod(0.6710436067037893 * i, 1.0);
    positions_m[3 * i + 2] = 6.0 * fmod(0.5497004779019703 * i, 1.0);
    normals[3 * i + i % 3] = i % 2 == 0 ? 1.0f : -1.0f;
    status_of_one[i] = (float)nlg_irradiance(grid, positions_m + 3 * i, normals + 3 * i, rgb + 3 * i);
  }
  print("light.one", rgb, 3 * kPositions);
  print("status.one", status_of_one, kPositions);
  nlg_irradiances(grid, positions_m, normals, kPositions, rgb, status, scratch);
  for (int i = 0; i < kPositions; ++i) status_of_all[i] = (float)status[i];
  print("light.many", rgb, 3 * kPositions);
  print("status.many", status_of_all, kPositions);
  nlg_look_up_scratch_free(scratch);
  nlg_light_grid_free(grid);
  return 0;
}

int main(int argc, char** argv) {
  if (argc != 3) return fprintf(stderr, "usage: numbers WEIGHTS.safetensors GRID.safetensors\n"), 2;
  return printTheta(argv[1]) || printLight(argv[2]);
}
