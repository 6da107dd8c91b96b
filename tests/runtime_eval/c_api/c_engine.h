/* theta of functions and its values at the support points, by the C interface alone. */
#ifndef NLG_C_ENGINE_H_
#define NLG_C_ENGINE_H_

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* theta (count x D), corrected, and values (count x P): allocated, for the caller to free. Returns 0, or which step failed. */
int engine_bake(const char* path, const unsigned char* phi, const unsigned char* validity, size_t count, float** theta,
                float** values);

#ifdef __cplusplus
}
#endif

#endif
