/* A program in strict C99 that has nlg_light_grid.h. */
#include "runtime_eval/shader_grid/nlg_light_grid.h"

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
