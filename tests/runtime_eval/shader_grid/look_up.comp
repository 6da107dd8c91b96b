#version 450
#extension GL_GOOGLE_include_directive : require
// Irradiance at a list of places, whole groups of 64, by a shader grid: what the tests compare with lookUpIrradiance.
layout(local_size_x = 64) in;
// one buffer, as words and as fours
layout(std430, binding = 0) readonly buffer Words { uint words[]; };
layout(std430, binding = 0) readonly buffer Fours { uvec4 fours[]; };
layout(std430, binding = 1) readonly buffer Places { vec4 places[]; };  // position, normal
layout(std430, binding = 2) writeonly buffer Lights { vec4 lights[]; };  // irradiance, status

uvec4 nlgHeader(int i) { return fours[i]; }
uvec4 nlgFour(int i) { return fours[i]; }
uint nlgWord(int i) { return words[i]; }
#include "runtime_eval/shader_grid/look_up.glsl"

void main() {
  uint i = gl_GlobalInvocationID.x;
  NlgLight light = nlgIrradiance(places[2u * i].xyz, places[2u * i + 1u].xyz);
  lights[i] = vec4(light.irradiance, float(light.status));
}
