#include "validate/generators/function_counts.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "runtime_eval/support/weighting_function.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {

FunctionSet readHeldOut(std::vector<std::string> paths) {
  // the order decides which functions stand for duplicates and which are drawn: that of names, however a shell lists them
  const auto nameOf = [](const std::string& path) { return std::filesystem::path(path).filename(); };
  std::stable_sort(paths.begin(), paths.end(), [&](const auto& a, const auto& b) { return nameOf(a) < nameOf(b); });
  FunctionSet set = readFunctionSet(paths, supportPattern().hash, kSupportPointCount);
  if (set.functionCount() == 0) throw InputError(paths.front(), "held-out functions", "at least one in all shards", "none");
  if (set.test_point_count == 0)
    throw InputError(paths.front(), "test points", "shards made with --held-out", "shards without them");
  if (const uint64_t expected = hashPoints(testPoints(set.test_point_count)); set.test_pattern_hash != expected) {
    throw InputError(paths.front(), "attribute test_pattern_hash", std::to_string(expected),
                     std::to_string(set.test_pattern_hash));
  }
  return set;
}

FunctionCounts countFunctions(const std::vector<std::string>& training, const std::vector<std::string>& held_out,
                              const FunctionSet& set, int thread_count) {
  const DuplicateRule rule = readShardHeader(held_out.front(), supportPattern().hash, kSupportPointCount).duplicate_rule;
  FunctionCounts counts;
  std::vector<std::string> all = training;
  all.insert(all.end(), held_out.begin(), held_out.end());
  DuplicateFilter filter;
  KnownFunctionSearch search(rule, set);
  // a shard is read while the one before is searched and the one before that is filtered: HDF5 is for one thread at a time, and
  // filtering moves the rows that the search reads
  constexpr size_t kStageCount = 3;
  std::array<Shard, kStageCount> shards;
  const auto read = [&](size_t i) { shards[i % kStageCount] = readShard(all[i], supportPattern().hash, kSupportPointCount); };
  const auto searchFor = [&](size_t i) {
    if (i >= training.size()) return;
    const Shard& shard = shards[i % kStageCount];
    for (uint64_t n = 0; n < shard.counts.functions; ++n) search.see(functionAt(shard, n));
  };
  const auto count = [&](size_t i) {
    Shard& shard = shards[i % kStageCount];
    filter.removeKnown(&shard);
    addCounts(shard.counts, &counts.all);
  };
  for (size_t step = 0; step < all.size() + kStageCount - 1; ++step) {
    parallelFor(kStageCount, thread_count, [&](uint64_t stage, int) {
      if (step < stage || step - stage >= all.size()) return;
      switch (const size_t i = step - stage; stage) {
        case 0:
          return read(i);
        case 1:
          return searchFor(i);
        default:
          return count(i);
      }
    });
  }
  counts.known = search.known();
  return counts;
}

}  // namespace nlg
