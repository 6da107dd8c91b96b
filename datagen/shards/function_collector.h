// Decides, probe after probe in visiting order, what becomes of each: kept as a distinct function, or left out and counted.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
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

// Functions that the bare tent gives well enough.
struct TentCounts {
  uint64_t count = 0;
  double rmse_sum = 0.0;
  double meanRmse() const { return count > 0 ? rmse_sum / static_cast<double>(count) : 0.0; }
};

struct CollectorLimits {
  uint64_t functions = std::numeric_limits<uint64_t>::max();       // stop once so many are kept
  uint64_t visited_probes = std::numeric_limits<uint64_t>::max();  // or so many probes have been looked at
};

class FunctionCollector {
 public:
  // shape            point counts of the functions
  // chunk_functions  how many functions come together before they are handed on
  // spool_folder     where the samples of kept functions lie meanwhile: see RowSpool
  // throws           OutputError when the spool's disk refuses
  FunctionCollector(const FunctionRows& shape, const DuplicateRule& rule, uint64_t chunk_functions, const CollectorLimits& limits,
                    const std::string& spool_folder);
  // A shard's: its points, its rule and its chunks.
  FunctionCollector(const Shard& header, const CollectorLimits& limits, const std::string& spool_folder)
      : FunctionCollector(header, header.duplicate_rule, kChunkFunctions, limits, spool_folder) {}

  // From now on appends to `of_probes`, for every probe, its function's number: kFreeSpace in free space and where the bare tent
  // stands for the function, kNoWeight where there is none (light_grid.h).
  void tellFunctions(std::vector<uint32_t>* of_probes) { of_probes_ = of_probes; }

  // Goes through the probes of the next block, as far as the limits go; returns the full chunks that came together.
  // throws OutputError when the spool's disk refuses
  std::vector<FunctionRows> add(const ProbeBlock& block);
  // The functions that make no full chunk; call it last.
  FunctionRows takeRest();

  // The samples of the n-th kept function; `samples` holds them. Any number of threads may read, while none adds.
  StoredFunction read(uint64_t n, std::vector<uint8_t>* samples) const { return spool_.read(n, samples); }

  bool full() const { return counts_.functions >= limits_.functions || counts_.visited_probes >= limits_.visited_probes; }
  const ShardCounts& counts() const { return counts_; }
  const TentCounts& bareTents() const { return bare_tents_; }  // in none of the counts but that of visited probes
  const DifferenceStatistics& differences() const { return differences_; }
  uint64_t spooledBytes() const { return spool_.byteCount(); }
  double seconds() const { return seconds_; }  // that all of it took, by the clock

 private:
  // The number of the function that stands for a row of the block.
  uint32_t functionOf(const ProbeBlock& block, uint64_t row, std::vector<FunctionRows>* chunks);

  uint64_t chunk_functions_;
  CollectorLimits limits_;
  ShardCounts counts_;
  TentCounts bare_tents_;
  RowSpool spool_;
  std::vector<uint8_t> spooled_;  // the samples that duplicates are compared with
  DuplicateIndex index_;
  DifferenceStatistics differences_;
  FunctionRows chunk_;
  std::vector<uint32_t>* of_probes_ = nullptr;
  double seconds_ = 0.0;
};

}  // namespace nlg
