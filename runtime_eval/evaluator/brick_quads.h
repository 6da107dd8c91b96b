// Layout of a brick of logits (dictionary.h) for look-ups on CPUs and in shaders: two neighbouring words hold the eight nodes
// of a cell.
//
// Word x + r * (y + (r - 1) * z) holds four nodes, from its lowest byte on: (x, y, z), (x, y + 1, z), (x, y, z + 1), (x, y + 1, z + 1);
// x below r, y and z below r - 1. Three times the bytes of the brick, and one line of the cache where a brick has four rows in three.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime_eval/evaluator/dictionary.h"

namespace nlg {

// Words of one brick.
constexpr size_t quadCount(int resolution) {
  const auto r = static_cast<size_t>(resolution);
  return r * (r - 1) * (r - 1);
}
inline constexpr size_t kMaxQuads = quadCount(kMaxBrickResolution);

// brick   r³ steps, as packBrick gives them
// quads   quadCount(resolution) words
void packQuads(int resolution, const int8_t* brick, uint32_t* quads);

// sigmoid(L) at a point, which is limited to the cube: what evaluateBrick says of the brick that was packed.
float evaluateQuads(int resolution, const LocalPoint& point, float step, const uint32_t* quads);

}  // namespace nlg
