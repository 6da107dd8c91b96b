#version 450
#extension GL_GOOGLE_include_directive : require
// Irradiance out of a resampled texture at a list of places in its box, whole groups of 64.
layout(local_size_x = 64) in;
layout(binding = 0) uniform sampler3D light;
layout(std430, binding = 1) readonly buffer Places { vec4 places[]; };  // share of the box, normal
layout(std430, binding = 2) writeonly buffer Lights { vec4 lights[]; };

vec4 nlgSlabs(vec3 at) { return textureLod(light, at, 0.0f); }
#include "runtime_eval/shader_grid/resampled.glsl"

void main() {
  uint i = gl_GlobalInvocationID.x;
  float depth = float(textureSize(light, 0).z / 7);
  lights[i] = vec4(nlgResampledIrradiance(places[2u * i].xyz, depth, places[2u * i + 1u].xyz), 0.0f);
}
