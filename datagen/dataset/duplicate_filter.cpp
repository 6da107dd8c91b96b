#include <optional>
#include <utility>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/nameless_file.h"
#include "datagen/dataset/shard_check.h"
#include "datagen/dataset/shard_reader.h"
#include "datagen/dataset/shard_rows.h"
#include "tool/error.h"

namespace nlg {
namespace {

uint64_t functionCountOf(const std::vector<std::string>& shards) {
  uint64_t count = 0;
  for (const std::string& path : shards) count += ShardReader(path).functionCount();
  return count;
}

}  // namespace

struct DuplicateFilter::Impl {
  explicit Impl(const std::vector<std::string>& paths) : shards(paths), rows(paths) {}

  // Steps on to what removeKnown was given: another shard, or more rows of the same.
  void begin(const Shard& shard) {
    if (begun_count == 0 || shards[begun_count - 1] != shard.path) {
      NLG_CHECK(begun_count, <, shards.size());
      NLG_CHECK(shards[begun_count], ==, shard.path);
      ++begun_count;
      next_row = 0;
    }
    if (!index) {
      rule = shard.duplicate_rule;
      index.emplace(rule, shard.point_count, [this](uint64_t id) { return samples(id); });
    }
    requireSameRule(shard, rule);
    current = &shard;
    first_of_current = index->functionCount();
  }

  StoredFunction samples(uint64_t id) {
    // those of the shard at work have moved to the front of its arrays
    if (id >= first_of_current) return functionAt(*current, id - first_of_current);
    return earlier ? earlier(id) : rows.at(places[id].first, places[id].second);
  }

  bool isDuplicate(const StoredFunction& function) {
    const uint64_t place = seen_count++, row = next_row++;
    if (is_banded) return is_duplicate[place];
    if (index->findOrAdd(function)) return true;
    if (!earlier) places.emplace_back(static_cast<uint32_t>(begun_count - 1), static_cast<uint32_t>(row));
    return false;
  }

  std::vector<std::string> shards;
  DuplicateIndex::Fetch earlier;
  ShardRows rows;
  bool is_banded = false;
  std::vector<bool> is_duplicate;  // of all functions, where they are looked for band by band
  std::optional<DuplicateIndex> index;
  std::vector<std::pair<uint32_t, uint32_t>> places;  // of what was kept, by id: shard and row; where rows gives the samples
  DuplicateRule rule;
  size_t begun_count = 0;                 // shards
  uint64_t seen_count = 0, next_row = 0;  // functions in all; of the present shard
  const Shard* current = nullptr;
  uint64_t first_of_current = 0;
};

DuplicateFilter::DuplicateFilter(const std::vector<std::string>& shards, DuplicateFilterOptions options)
    : impl_(std::make_unique<Impl>(shards)) {
  impl_->earlier = std::move(options.earlier);
  impl_->is_banded = functionCountOf(shards) > options.memory_bytes / kDuplicateBytesAFunction;
  if (impl_->is_banded) impl_->is_duplicate = findDuplicates(shards, options.memory_bytes, temporaryFolder());
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
