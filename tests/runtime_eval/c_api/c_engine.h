/* theta of functions and its values at the support points, by the C interface alone. */
#ifndef NLG_C_ENGINE_H_
#define NLG_C_ENGINE_H_

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* theta (count x D), corrected, and values (count x P): allocated, for the caller to free. Returns 0, or which step failed. */
int engine_bake(const char* path, const unsigned char* phi, const unsigned char* validity, const unsigned char* blend_sum,
                size_t count, float** theta, float** values);

/* Irradiance at positions (count x 3) with normals (count x 3) out of a light grid's bytes, by the C interface alone, one at a time
 * and batched: rgb and batched_rgb (count x 3), status (count). Returns 0, or which step failed. */
int engine_light(const void* bytes, size_t byte_count, const double* positions_m, const float* normals, size_t count, float* rgb,
                 float* batched_rgb, unsigned char* status);

#ifdef __cplusplus
}
#endif

#endif
