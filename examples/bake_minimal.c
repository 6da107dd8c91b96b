/* The same from C: the function of a probe beside a wall, by the policy of nlg-bake.
 *
 *   bake_minimal_c WEIGHTS.safetensors
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "nlg/nlg.h"

int main(int argc, char** argv) {
  static uint8_t phi[NLG_SUPPORT_POINT_COUNT];
  static float x[NLG_SUPPORT_POINT_COUNT], y[NLG_SUPPORT_POINT_COUNT], z[NLG_SUPPORT_POINT_COUNT];
  static float values[NLG_SUPPORT_POINT_COUNT];
  static uint8_t validity[NLG_SUPPORT_POINT_COUNT / 8];
  nlg_generator* generator;
  nlg_scratch* scratch;
  const float* points;
  uint64_t pattern_hash;
  char detail[256];
  if (argc != 2) return fprintf(stderr, "usage: bake_minimal_c WEIGHTS.safetensors\n"), 2;
  nlg_status status = nlg_generator_load(argv[1], &generator, detail, sizeof detail);
  if (status != NLG_OK) return fprintf(stderr, "%s (%s)\n", detail, nlg_status_name(status)), 3;
  if (nlg_scratch_create(generator, NULL, &scratch) != NLG_OK || nlg_support_pattern(&points, &pattern_hash) != NLG_OK) return 1;
  printf("%s, %zu numbers a function\n", nlg_representation_name(generator), nlg_theta_count(generator));

  /* a wall from x = 0.3 to 0.4: the tent on the probe's side of it, nothing behind */
  for (int p = 0; p < NLG_SUPPORT_POINT_COUNT; ++p) {
    x[p] = points[3 * p];
    y[p] = points[3 * p + 1];
    z[p] = points[3 * p + 2];
    const float tent = (1.0f - fabsf(x[p])) * (1.0f - fabsf(y[p])) * (1.0f - fabsf(z[p]));
    phi[p] = x[p] < 0.3f ? (uint8_t)lroundf(255.0f * tent) : 0;
    if (x[p] < 0.3f || x[p] > 0.4f) validity[p / 8] |= (uint8_t)(1 << (p % 8));
  }
  float* theta = malloc(nlg_theta_count(generator) * sizeof(float));
  if (theta == NULL) return 1;
  nlg_made made;
  if (nlg_make_theta(generator, phi, validity, NULL, 1, theta, &made, scratch) != NLG_OK) return 1;
  nlg_evaluate(generator, theta, NLG_SUPPORT_POINT_COUNT, x, y, z, values, scratch);

  printf("at the first support point: %.4f, stored %.4f\n", phi[0] / 255.0, values[0]);
  printf("network:   RMSE %.5f\n", made.network.rmse);
  printf("corrected: RMSE %.5f\n", made.corrected.rmse);
  printf("fitted:    RMSE %.5f\n", made.fitted.rmse);
  printf("stored:    RMSE %.5f, %s\n", made.stored.rmse, made.stored.passes ? "accepted" : "still failing");
  free(theta);
  nlg_scratch_free(scratch);
  nlg_generator_free(generator);
  return 0;
}
