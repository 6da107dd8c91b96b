#include "datagen/shards/function_collector.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

void DifferenceStatistics::add(double difference) {
  ++count_;
  sum_ += difference;
  worst_ = std::max(worst_, difference);
  const double bin = scale_ > 0.0 ? 256.0 * difference / scale_ : 0.0;
  ++histogram_[static_cast<size_t>(std::clamp(std::ceil(bin), 0.0, 256.0))];
}

double DifferenceStatistics::percentile(double share) const {
  uint64_t below = 0;
  for (size_t bin = 0; bin < histogram_.size(); ++bin) {
    below += histogram_[bin];
    if (static_cast<double>(below) >= share * static_cast<double>(count_)) return scale_ * static_cast<double>(bin) / 256.0;
  }
  return worst_;
}

FunctionCollector::FunctionCollector(const FunctionRows& shape, const DuplicateRule& rule, uint64_t chunk_functions,
                                     const CollectorLimits& limits, const std::string& spool_folder)
    : chunk_functions_(chunk_functions),
      limits_(limits),
      spool_(spool_folder, shape.point_count),
      index_(rule, shape.point_count, [this](uint64_t id) { return spool_.read(id, &spooled_); }),
      differences_(rule.rms),
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
    differences_.add(match->rms_difference);
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
    uint32_t function = outcome == ProbeOutcome::free_space ? kFreeSpace : kNoWeight;
    if (outcome == ProbeOutcome::function) function = functionOf(block, row++, &chunks);
    if (of_probes_ != nullptr) of_probes_->push_back(function);
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return chunks;
}

FunctionRows FunctionCollector::takeRest() { return std::exchange(chunk_, emptyLike(chunk_)); }

}  // namespace nlg
