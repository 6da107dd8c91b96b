/* A program in strict C99 that has nlg_light_grid.h, and the C interface's header beside it. */
#include "nlg/nlg.h"
#include "runtime_eval/shader_grid/nlg_light_grid.h"

/* a status of one is a status of the other */
typedef char same_numbers[(int)NLG_GRID_LIT == (int)NLG_LIT && (int)NLG_GRID_FAINT == (int)NLG_FAINT &&
                                  (int)NLG_GRID_UNLIT == (int)NLG_UNLIT && (int)NLG_GRID_OUTSIDE == (int)NLG_OUTSIDE
                              ? 1
                              : -1];

int cHeaderIrradiance(const uint8_t* bytes, size_t size, const float* position_m, const float* normal, float* rgb);
int cHeaderIsWhole(const uint8_t* bytes, size_t size);

int cHeaderIrradiance(const uint8_t* bytes, size_t size, const float* position_m, const float* normal, float* rgb) {
  const NlgGrid grid = {bytes, size};
  return (int)nlgIrradiance(&grid, position_m, normal, rgb);
}

int cHeaderIsWhole(const uint8_t* bytes, size_t size) {
  const NlgGrid grid = {bytes, size};
  return nlgIsWhole(&grid);
}
