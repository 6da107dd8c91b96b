#include "validate/errors/function_counts.h"

#include "runtime_eval/support/weighting_function.h"

namespace nlg {

FunctionCounts countFunctions(const std::vector<std::string>& training, const std::vector<std::string>& held_out,
                              const FunctionSet& set) {
  const auto read = [](const std::string& path) { return readShard(path, supportPattern().hash, kSupportPointCount); };
  const DuplicateRule rule = readShardHeader(held_out.front(), supportPattern().hash, kSupportPointCount).duplicate_rule;
  FunctionCounts counts;
  std::vector<std::string> all = training;
  all.insert(all.end(), held_out.begin(), held_out.end());
  DuplicateFilter filter(all);
  const auto add = [&](Shard* shard) {
    filter.removeKnown(shard);
    addCounts(shard->counts, &counts.all);
  };
  KnownFunctionSearch search(rule, set);
  for (const std::string& path : training) {
    Shard shard = read(path);
    for (uint64_t n = 0; n < shard.counts.functions; ++n) {
      const StoredFunction stored = storedFunction(shard, n);
      search.see({stored.phi, stored.validity});
    }
    add(&shard);
  }
  for (const std::string& path : held_out) {
    Shard shard = read(path);
    add(&shard);
  }
  counts.known = search.known();
  return counts;
}

}  // namespace nlg
