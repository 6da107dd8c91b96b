/* An engine in C: what c_api_test.cpp compares with the C++ library. Compiled as strict C11. */
#include "c_engine.h"

#include <stdlib.h>

#include "nlg/nlg.h"

int engine_bake(const char* path, const unsigned char* phi, const unsigned char* validity, const unsigned char* blend_sum,
                size_t count, float** theta, float** values) {
  nlg_generator* generator = NULL;
  nlg_scratch* scratch = NULL;
  const float* points = NULL;
  uint64_t hash = 0;
  char detail[256];
  float *x, *y, *z;
  size_t i, n, theta_count;
  *theta = *values = NULL;
  if (nlg_generator_load(path, &generator, detail, sizeof detail) != NLG_OK) return 1;
  if (nlg_support_pattern(&points, &hash) != NLG_OK || nlg_scratch_create(generator, NULL, &scratch) != NLG_OK) return 2;

  theta_count = nlg_theta_count(generator);
  *theta = malloc(count * theta_count * sizeof(float));
  if (nlg_make_theta(generator, phi, validity, blend_sum, count, *theta, NULL, scratch) != NLG_OK) return 3;

  x = malloc(3 * NLG_SUPPORT_POINT_COUNT * sizeof(float));
  y = x + NLG_SUPPORT_POINT_COUNT;
  z = y + NLG_SUPPORT_POINT_COUNT;
  for (i = 0; i < NLG_SUPPORT_POINT_COUNT; ++i) {
    x[i] = points[3 * i];
    y[i] = points[3 * i + 1];
    z[i] = points[3 * i + 2];
  }
  *values = malloc(count * NLG_SUPPORT_POINT_COUNT * sizeof(float));
  for (n = 0; n < count; ++n) {
    nlg_evaluate(generator, *theta + n * theta_count, NLG_SUPPORT_POINT_COUNT, x, y, z, *values + n * NLG_SUPPORT_POINT_COUNT,
                 scratch);
  }
  free(x);
  nlg_scratch_free(scratch);
  nlg_generator_free(generator);
  return 0;
}

int engine_light(const void* bytes, size_t byte_count, const double* positions_m, const float* normals, size_t count, float* rgb,
                 float* batched_rgb, unsigned char* status) {
  nlg_light_grid* grid = NULL;
  nlg_look_up_scratch* scratch = NULL;
  char detail[256];
  size_t i;
  int differs = 0;
  if (nlg_light_grid_load_bytes(bytes, byte_count, &grid, detail, sizeof detail) != NLG_OK) return 1;
  if (nlg_look_up_scratch_create(&scratch) != NLG_OK) return 2;
  if (!nlg_light_grid_has_light(grid) || nlg_light_grid_probe_count(grid) == 0) return 3;
  nlg_irradiances(grid, positions_m, normals, count, batched_rgb, status, scratch);
  for (i = 0; i < count; ++i) {
    const nlg_light_status one = nlg_irradiance(grid, positions_m + 3 * i, normals + 3 * i, rgb + 3 * i);
    if (one != (nlg_light_status)status[i]) differs = 1;
  }
  nlg_look_up_scratch_free(scratch);
  nlg_light_grid_free(grid);
  return differs ? 4 : 0;
}
