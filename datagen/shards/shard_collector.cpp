#include "datagen/shards/shard_collector.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

ShardCollector::ShardCollector(const Shard& header, const CollectorLimits& limits, const std::string& spool_folder)
    : limits_(limits),
      spool_(spool_folder, header.point_count),
      index_(header.duplicate_rule, header.point_count, [this](uint64_t id) { return spool_.read(id); }),
      differences_(header.duplicate_rule.rms),
      chunk_(emptyLike(header)) {}

std::vector<FunctionRows> ShardCollector::add(const ProbeBlock& block) {
  std::vector<FunctionRows> chunks;
  uint64_t row = 0;
  for (const ProbeOutcome outcome : block.outcomes) {
    if (full()) break;
    ++counts_.visited_probes;
    counts_.free_space += outcome == ProbeOutcome::free_space;
    counts_.in_solid += outcome == ProbeOutcome::in_solid;
    counts_.empty += outcome == ProbeOutcome::empty;
    if (outcome != ProbeOutcome::function) continue;
    const uint64_t n = row++;
    counts_.solid_functions += (block.functions.flags[n] & kFlagInSolid) != 0;
    const StoredFunction samples = functionAt(block.functions, n);
    if (const auto match = index_.findOrAdd(samples)) {
      ++counts_.duplicates;
      differences_.add(match->rms_difference);
      continue;
    }
    spool_.append(samples);
    appendRows(block.functions, n, 1, &chunk_);
    ++counts_.functions;
    if (chunk_.functionCount() == kChunkFunctions) chunks.push_back(std::exchange(chunk_, emptyLike(chunk_)));
  }
  return chunks;
}

FunctionRows ShardCollector::takeRest() { return std::exchange(chunk_, emptyLike(chunk_)); }

}  // namespace nlg
