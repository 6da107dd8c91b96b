#include "validate/errors/function_counts.h"

#include "runtime_eval/support/support_pattern.h"

namespace nlg {

FunctionCounts countFunctions(const std::vector<std::string>& training, const std::vector<std::string>& held_out,
                              uint64_t held_out_count) {
  FunctionCounts counts;
  DuplicateFilter filter;
  const auto add = [&](const std::string& path) {
    Shard shard = readShard(path, supportPattern().hash, kSupportPointCount);
    filter.removeKnown(&shard);
    addCounts(shard.counts, &counts.all);
    return shard.counts.functions;
  };
  for (const std::string& path : training) add(path);
  uint64_t new_count = 0;
  for (const std::string& path : held_out) new_count += add(path);
  counts.held_out_in_training = held_out_count - new_count;
  return counts;
}

}  // namespace nlg
