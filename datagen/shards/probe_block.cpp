#include "datagen/shards/probe_block.h"

#include <cmath>

namespace nlg {
namespace {

void appendSamples(const GeneratedFunction& function, size_t first, size_t count, std::vector<uint8_t>& bytes) {
  for (size_t i = first; i < first + count; ++i) {
    bytes.push_back(function.valid[i] ? static_cast<uint8_t>(std::lround(255.0f * function.phi[i])) : 0);
  }
}

void appendBits(const std::vector<uint8_t>& bits, size_t first, size_t count, std::vector<uint8_t>& bytes) {
  for (size_t i = 0; i < count; i += 8) {
    uint8_t byte = 0;
    for (size_t b = 0; b < 8; ++b) byte |= static_cast<uint8_t>(bits[first + i + b] << b);
    bytes.push_back(byte);
  }
}

uint8_t functionFlags(const GeneratedFunction& function, size_t point_count) {
  size_t seen_count = 0;
  for (size_t i = 0; i < point_count; ++i) seen_count += function.seen[i];
  uint8_t flags = function.open_shell ? kFlagOpenShell : 0;
  if (100 * seen_count < point_count) flags |= kFlagFewSeen;
  if (function.in_solid) flags |= kFlagInSolid;
  return flags;
}

}  // namespace

void appendFunction(const GeneratedFunction& function, const glm::dvec3& position_m, float spacing_m, FunctionRows* rows) {
  const auto points = static_cast<size_t>(rows->point_count), test = static_cast<size_t>(rows->test_point_count);
  appendSamples(function, 0, points, rows->phi);
  appendBits(function.valid, 0, points, rows->validity);
  rows->blend_sum.resize(rows->blend_sum.size() + points, 255);
  appendBits(function.seen, 0, points, rows->seen);
  appendSamples(function, points, test, rows->phi_test);
  appendBits(function.valid, points, test, rows->validity_test);
  appendBits(function.seen, points, test, rows->seen_test);
  for (int axis = 0; axis < 3; ++axis) rows->probe_position_m.push_back(position_m[axis]);
  rows->spacing_m.push_back(spacing_m);
  rows->flags.push_back(functionFlags(function, points));
}

}  // namespace nlg
