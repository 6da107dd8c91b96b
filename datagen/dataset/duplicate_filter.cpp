#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/nameless_file.h"
#include "datagen/dataset/packed_functions.h"
#include "datagen/dataset/shard_check.h"
#include "datagen/dataset/shard_reader.h"
#include "tool/error.h"

namespace nlg {
namespace {

std::vector<uint64_t> functionCountsOf(const std::vector<std::string>& shards) {
  std::vector<uint64_t> counts;
  for (const std::string& path : shards) counts.push_back(ShardReader(path).functionCount());
  return counts;
}

}  // namespace

struct DuplicateFilter::Impl {
  explicit Impl(const std::vector<std::string>& paths) : shards(paths), function_counts(functionCountsOf(paths)) {}

  // Steps on to what removeKnown was given: another shard, or more rows of the same. A shard that was named twice is another one: it
  // is for whoever named it to say so.
  void begin(const Shard& shard) {
    const bool has_ended = begun_count > 0 && begun_count < shards.size() && next_row == function_counts[begun_count - 1];
    if (begun_count == 0 || shards[begun_count - 1] != shard.path || (has_ended && shards[begun_count] == shard.path)) {
      NLG_CHECK(begun_count, <, shards.size());
      NLG_CHECK(shards[begun_count], ==, shard.path);
      ++begun_count;
      next_row = 0;
    }
    const uint64_t count = function_counts[begun_count - 1];
    if (next_row + shard.functionCount() > count)
      throw InputError(shard.path, "functions", std::to_string(count) + ", as when it was opened",
                       "more: it was changed meanwhile");
    if (!index) {
      rule = shard.duplicate_rule;
      index.emplace(rule, shard.point_count, [this](uint64_t id) { return samples(id); });
      if (!is_banded && !earlier) packed.emplace(shard.point_count, temporaryFolder());
    }
    requireSameRule(shard, rule);
    current = &shard;
    first_of_current = index->functionCount();
  }

  StoredFunction samples(uint64_t id) {
    // those of the shard at work have moved to the front of its arrays
    if (id >= first_of_current) return functionAt(*current, id - first_of_current);
    return earlier ? earlier(id) : packed->at(places[id]);
  }

  bool isDuplicate(const StoredFunction& function) {
    const uint64_t place = seen_count++;
    ++next_row;
    if (is_banded) return is_duplicate[place];
    if (index->findOrAdd(function)) return true;
    if (packed) places.push_back(packed->append(function));
    return false;
  }

  std::vector<std::string> shards;
  std::vector<uint64_t> function_counts;
  DuplicateIndex::Fetch earlier;
  bool is_banded = false;
  std::vector<bool> is_duplicate;  // of all functions, where they are looked for band by band
  std::optional<DuplicateIndex> index;
  std::optional<PackedFunctions> packed;  // what was kept, where nobody else has it
  std::vector<uint64_t> places;           // of it there, by id
  DuplicateRule rule;
  size_t begun_count = 0;                 // shards
  uint64_t seen_count = 0, next_row = 0;  // functions in all; of the present shard
  const Shard* current = nullptr;
  uint64_t first_of_current = 0;
};

DuplicateFilter::DuplicateFilter(const std::vector<std::string>& shards, DuplicateFilterOptions options)
    : impl_(std::make_unique<Impl>(shards)) {
  impl_->earlier = std::move(options.earlier);
  const uint64_t count = std::accumulate(impl_->function_counts.begin(), impl_->function_counts.end(), uint64_t{0});
  impl_->is_banded = count > options.memory_bytes / kDuplicateBytesAFunction;
  if (!impl_->is_banded) return;
  impl_->is_duplicate = findDuplicates(shards, options.memory_bytes, temporaryFolder());
  if (impl_->is_duplicate.size() != count)
    throw InputError(shards.front(), "functions of all shards", std::to_string(count) + ", as when they were opened",
                     std::to_string(impl_->is_duplicate.size()) + ": they were changed meanwhile");
}

DuplicateFilter::~DuplicateFilter() = default;

void DuplicateFilter::removeKnown(Shard* shard) {
  Impl& m = *impl_;
  m.begin(*shard);
  const uint64_t count = shard->functionCount();
  uint64_t kept = 0;
  for (uint64_t n = 0; n < count; ++n) {
    if (m.isDuplicate(functionAt(*shard, n))) continue;
    if (n != kept) moveRow(n, kept, shard);
    ++kept;
  }
  truncateRows(kept, shard);
  shard->counts.functions -= count - kept;
  shard->counts.duplicates += count - kept;
  m.current = nullptr;
}

}  // namespace nlg
