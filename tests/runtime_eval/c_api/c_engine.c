/* An engine in C: what c_api_test.cpp compares with the C++ library. Compiled as strict C11. */
#include "c_engine.h"

#include <stdlib.h>

#include "runtime_eval/c_api/nlg.h"

int engine_bake(const char* path, const unsigned char* phi, const unsigned char* validity, size_t count, float** theta,
                float** values) {
  nlg_generator* generator = NULL;
  nlg_scratch* scratch = NULL;
  const float* points = NULL;
  uint64_t hash = 0;
  char detail[256];
  float *x, *y, *z;
  size_t i, n, theta_count;
  *theta = *values = NULL;
  if (nlg_generator_load(path, NLG_FLOAT32, &generator, detail, sizeof detail) != NLG_OK) return 1;
  if (nlg_support_pattern(&points, &hash) != NLG_OK || nlg_scratch_create(generator, NULL, &scratch) != NLG_OK) return 2;

  theta_count = nlg_theta_count(generator);
  *theta = malloc(count * theta_count * sizeof(float));
  if (nlg_make_theta(generator, phi, validity, count, *theta, NULL, scratch) != NLG_OK) return 3;

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
