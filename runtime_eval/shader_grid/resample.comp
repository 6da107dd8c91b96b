#version 450
#extension GL_GOOGLE_include_directive : require
// Light of a box, resampled into one 3-D texture: what resampleLight (resampled_light.h) does, a texel an invocation.
//
// The texture is RGBA16F and holds seven slabs one behind the other along z, each as large as the box. Slab s has numbers 4 s …
// 4 s + 3 of a texel: nine coefficients of radiance, red, green and blue of each, all times the last number, the texel's say. That
// is its certainty: 1 where it is lit, 0 where there is no light, and FAINT_SAY at least where there is some. A filtered sum over
// the filtered last number so is the light of the texels that are sure, and of the faint ones where there are no others. Radiance
// is over the grid's scale, uintBitsToFloat(nlgHeader(3).x), which brings every light into the range of halves. resampled.glsl
// reads it.
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

const float FAINT_SAY = 1.0f / 256.0f;

void main() {
  uvec3 texel = gl_GlobalInvocationID;
  if (any(greaterThanEqual(texel, box.texel_count))) return;
  NlgRadiance radiance = nlgRadiance(box.low_m + (vec3(texel) + 0.5f) * box.texel_m);
  float say = max(radiance.certainty, radiance.sh[0] == vec3(0.0f) ? 0.0f : FAINT_SAY);
  float factor = say / uintBitsToFloat(nlgHeader(3).x);
  float numbers[28];
  for (int k = 0; k < 9; ++k) {
    vec3 number = radiance.sh[k] * factor;
    numbers[3 * k] = number.x, numbers[3 * k + 1] = number.y, numbers[3 * k + 2] = number.z;
  }
  numbers[27] = say;
  for (int slab = 0; slab < 7; ++slab) {
    ivec3 place = ivec3(texel) + ivec3(0, 0, slab * int(box.texel_count.z));
    imageStore(light, place, vec4(numbers[4 * slab], numbers[4 * slab + 1], numbers[4 * slab + 2], numbers[4 * slab + 3]));
  }
}
