// look_up.glsl as C++: GLM has GLSL's types and functions. What a shader computes, where there is no GPU.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>

#include "nlg/shader_grid.h"

namespace nlg::glsl {

using namespace glm;

inline const ShaderGrid* shader_grid = nullptr;
inline int reads = 0;  // bytes, since it was set to 0; the head is not counted

inline uvec4 fourAt(int i) {
  const uint32_t* words = &shader_grid->words.at(4 * static_cast<size_t>(i) + 3) - 3;
  return {words[0], words[1], words[2], words[3]};
}
inline uvec4 nlgHeader(int i) {
  if (i >= shader_grid->header_count) throw std::out_of_range("head");
  return fourAt(i);
}
inline uvec4 nlgFour(int i) {
  reads += 16;
  return fourAt(i);
}
inline uint nlgWord(int i) {
  reads += 4;
  return shader_grid->words.at(static_cast<size_t>(i));
}
inline int classCount() { return static_cast<int>(nlgHeader(3).y); }

#define NLG_NETWORK_4
#define NLG_NETWORK_44
#define NLG_NETWORK_88
#define NLG_FIELD
#define NLG_BRICK
#define NLG_HALVES
#define NLG_NEAR
#define NLG_CLASS_COUNT classCount()
#include "runtime_eval/shader_grid/look_up.glsl"

}  // namespace nlg::glsl
