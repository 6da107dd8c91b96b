// Decides, probe after probe in visiting order, what becomes of each: stored, or left out and counted.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "datagen/dataset/duplicate_index.h"
#include "datagen/dataset/row_spool.h"
#include "datagen/dataset/shard.h"
#include "datagen/shards/probe_block.h"

namespace nlg {

// How far duplicates lie from the functions that stand for them: RMS differences, 1/255.
class DifferenceStatistics {
 public:
  explicit DifferenceStatistics(double largest_possible) : scale_(largest_possible) {}
  void add(double difference);
  uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }
  double worst() const { return worst_; }
  double percentile(double share) const;  // within 1/256 of the largest possible, from above

 private:
  double scale_, sum_ = 0.0, worst_ = 0.0;
  uint64_t count_ = 0;
  std::array<uint64_t, 257> histogram_{};
};

struct CollectorLimits {
  uint64_t functions = 0;       // stop once so many are stored
  uint64_t visited_probes = 0;  // or so many probes have been looked at
};

class ShardCollector {
 public:
  // header         point counts and duplicate rule of the shard
  // spool_folder   where samples lie while the shard is under construction: see RowSpool
  ShardCollector(const Shard& header, const CollectorLimits& limits, const std::string& spool_folder);

  // Goes through the probes of the next block, as far as the limits go; returns the full chunks of kChunkFunctions functions that
  // came together. throws OutputError when the spool's disk refuses
  std::vector<FunctionRows> add(const ProbeBlock& block);
  // The functions that make no full chunk; call it last.
  FunctionRows takeRest();

  bool full() const { return counts_.functions >= limits_.functions || counts_.visited_probes >= limits_.visited_probes; }
  const ShardCounts& counts() const { return counts_; }
  const DifferenceStatistics& differences() const { return differences_; }
  uint64_t spooledBytes() const { return spool_.byteCount(); }

 private:
  CollectorLimits limits_;
  ShardCounts counts_;
  RowSpool spool_;
  DuplicateIndex index_;
  DifferenceStatistics differences_;
  FunctionRows chunk_;
};

}  // namespace nlg
