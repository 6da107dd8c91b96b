#include "datagen/functions/function_collector.h"

#include <chrono>
#include <utility>

#include "nlg/light_grid.h"

namespace nlg {
namespace {

void appendSamples(const GeneratedFunction& function, size_t first, size_t count, std::vector<uint8_t>& bytes) {
  for (size_t i = first; i < first + count; ++i) {
    bytes.push_back(function.valid[i] ? static_cast<uint8_t>(255.0f * function.phi[i] + 0.5f) : 0);
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

FunctionCollector::FunctionCollector(const FunctionRows& shape, const DuplicateRule& rule, uint64_t chunk_functions,
                                     const CollectorLimits& limits, const std::string& spool_folder)
    : chunk_functions_(chunk_functions),
      limits_(limits),
      spool_(spool_folder, shape.point_count),
      index_(rule, shape.point_count, [this](uint64_t id) { return spool_.read(id, &spooled_); }),
      chunk_(emptyLike(shape)) {}

uint32_t FunctionCollector::functionOf(const ProbeBlock& block, uint64_t row, std::vector<FunctionRows>* chunks) {
  counts_.solid_functions += (block.functions.flags[row] & kFlagInSolid) != 0;
  if (!block.bare_tent_rmse.empty() && block.bare_tent_rmse[row]) {
    ++bare_tents_.count;
    bare_tents_.rmse_sum += *block.bare_tent_rmse[row];
    return kFreeSpace;
  }
  const StoredFunction samples = functionAt(block.functions, row);
  if (const auto match = index_.findOrAdd(samples)) {
    ++counts_.duplicates;
    return static_cast<uint32_t>(match->id);
  }
  spool_.append(samples);
  appendRows(block.functions, row, 1, &chunk_);
  if (chunk_.functionCount() == chunk_functions_) chunks->push_back(std::exchange(chunk_, emptyLike(chunk_)));
  return static_cast<uint32_t>(counts_.functions++);
}

std::vector<FunctionRows> FunctionCollector::add(const ProbeBlock& block) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<FunctionRows> chunks;
  uint64_t row = 0;
  for (const ProbeOutcome outcome : block.outcomes) {
    if (full()) break;
    ++counts_.visited_probes;
    counts_.free_space += outcome == ProbeOutcome::free_space;
    counts_.in_solid += outcome == ProbeOutcome::in_solid;
    counts_.empty += outcome == ProbeOutcome::empty;
    counts_.outside += outcome == ProbeOutcome::outside;
    uint32_t function = outcome == ProbeOutcome::free_space ? kFreeSpace : kNoWeight;
    if (outcome == ProbeOutcome::function) function = functionOf(block, row++, &chunks);
    if (of_probes_ != nullptr) of_probes_->push_back(function);
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return chunks;
}

FunctionRows FunctionCollector::takeRest() { return std::exchange(chunk_, emptyLike(chunk_)); }

}  // namespace nlg
