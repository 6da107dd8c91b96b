#include <optional>
#include <utility>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/nameless_file.h"
#include "datagen/dataset/packed_functions.h"
#include "datagen/dataset/shard_check.h"

namespace nlg {

struct DuplicateFilter::Impl {
  void begin(const Shard& rows) {
    if (!index) {
      rule = rows.duplicate_rule;
      index.emplace(rule, rows.point_count, [this](uint64_t id) { return samples(id); });
      if (!earlier) packed.emplace(rows.point_count, temporaryFolder());
    }
    requireSameRule(rows, rule);
    current = &rows;
    first_of_current = index->functionCount();
  }

  StoredFunction samples(uint64_t id) {
    // those of the rows at work have moved to the front of their arrays
    if (id >= first_of_current) return functionAt(*current, id - first_of_current);
    return earlier ? earlier(id) : packed->at(places[id]);
  }

  bool isDuplicate(const StoredFunction& function) {
    if (index->findOrAdd(function)) return true;
    if (packed) places.push_back(packed->append(function));
    return false;
  }

  DuplicateIndex::Fetch earlier;
  std::optional<DuplicateIndex> index;
  std::optional<PackedFunctions> packed;  // what was kept, where nobody else has it
  std::vector<uint64_t> places;           // of it there, by id
  DuplicateRule rule;
  const Shard* current = nullptr;
  uint64_t first_of_current = 0;
};

DuplicateFilter::DuplicateFilter(DuplicateIndex::Fetch earlier) : impl_(std::make_unique<Impl>()) {
  impl_->earlier = std::move(earlier);
}

DuplicateFilter::~DuplicateFilter() = default;

void DuplicateFilter::removeKnown(Shard* rows) {
  Impl& m = *impl_;
  m.begin(*rows);
  const uint64_t count = rows->functionCount();
  uint64_t kept = 0;
  for (uint64_t n = 0; n < count; ++n) {
    if (m.isDuplicate(functionAt(*rows, n))) continue;
    if (n != kept) moveRow(n, kept, rows);
    ++kept;
  }
  truncateRows(kept, rows);
  rows->counts.functions -= count - kept;
  rows->counts.duplicates += count - kept;
  m.current = nullptr;
}

}  // namespace nlg
