#version 450
#extension GL_GOOGLE_include_directive : require
// Light of a box, resampled into one 3-D texture: what resampleLight (resampled_light.h) does, a texel an invocation.
//
// The texture is RGBA16F and holds seven slabs one behind the other along z, each as large as the box. Slab s has numbers 4 s …
// 4 s + 3 of a texel: nine coefficients of radiance, red, green and blue of each, then their certainty: 1 where there is light, 0
// where there is none. Radiance fades with it, so that a filtered sum over the filtered last number is the light of the lit texels
// alone. Numbers are over the grid's scale, uintBitsToFloat(nlgHeader(3).x), which brings every light into the range of halves.
// resampled.glsl reads it.
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430, binding = 0) readonly buffer Grid { uvec4 grid[]; };
layout(std140, binding = 1) uniform Box {
  vec3 low_m;    // the box's low corner
  vec3 texel_m;  // a texel's edges; its centre lies half of them inside
  uvec3 texel_count;
} box;
layout(rgba16f, binding = 2) writeonly uniform image3D light;

uvec4 nlgHeader(int i) { return grid[i]; }
uvec4 nlgFour(int i) { return grid[i]; }
uint nlgWord(int i) { return grid[i >> 2][i & 3]; }
#include "look_up.glsl"

void main() {
  uvec3 texel = gl_GlobalInvocationID;
  if (any(greaterThanEqual(texel, box.texel_count))) return;
  NlgRadiance radiance = nlgRadiance(box.low_m + (vec3(texel) + 0.5f) * box.texel_m);
  float per_scale = 1.0f / uintBitsToFloat(nlgHeader(3).x);
  float numbers[28];
  for (int k = 0; k < 9; ++k) {
    vec3 number = radiance.sh[k] * per_scale;
    numbers[3 * k] = number.x, numbers[3 * k + 1] = number.y, numbers[3 * k + 2] = number.z;
  }
  numbers[27] = radiance.certainty;
  for (int slab = 0; slab < 7; ++slab) {
    ivec3 place = ivec3(texel) + ivec3(0, 0, slab * int(box.texel_count.z));
    imageStore(light, place, vec4(numbers[4 * slab], numbers[4 * slab + 1], numbers[4 * slab + 2], numbers[4 * slab + 3]));
  }
}
