#include <optional>
#include <utility>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/row_spool.h"
#include "tool/error.h"

namespace nlg {
struct DuplicateFilter::Impl {
  StoredFunction samples(uint64_t id) {
    // those of the shard at work have moved to the front of its arrays
    if (id >= first_of_current) return functionAt(*current, id - first_of_current);
    return earlier ? earlier(id) : spool->read(id);
  }

  DuplicateIndex::Fetch earlier;
  std::optional<RowSpool> spool;  // by id, when the caller does not keep the samples
  std::optional<DuplicateIndex> index;
  DuplicateRule rule;
  const Shard* current = nullptr;
  uint64_t first_of_current = 0;
};

DuplicateFilter::DuplicateFilter(DuplicateIndex::Fetch earlier) : impl_(std::make_unique<Impl>()) {
  impl_->earlier = std::move(earlier);
}

DuplicateFilter::~DuplicateFilter() = default;

void DuplicateFilter::removeKnown(Shard* shard) {
  Impl& m = *impl_;
  if (!m.index) {
    m.rule = shard->duplicate_rule;
    if (!m.earlier) m.spool.emplace(temporaryFolder(), shard->point_count);
    m.index.emplace(m.rule, shard->point_count, [&m](uint64_t id) { return m.samples(id); });
  }
  if (!(shard->duplicate_rule == m.rule)) {
    const auto text = [](const DuplicateRule& rule) {
      return std::to_string(rule.rms) + " and " + std::to_string(rule.validity_points);
    };
    throw InputError(shard->path, "attributes duplicate_rms and duplicate_validity_points",
                     text(m.rule) + " as in the first shard", text(shard->duplicate_rule));
  }
  m.current = shard;
  m.first_of_current = m.index->functionCount();
  const uint64_t count = shard->functionCount();
  uint64_t kept = 0;
  for (uint64_t n = 0; n < count; ++n) {
    if (m.index->findOrAdd(functionAt(*shard, n))) continue;
    if (m.spool) m.spool->append(functionAt(*shard, n));
    if (n != kept) moveRow(n, kept, shard);
    ++kept;
  }
  truncateRows(kept, shard);
  shard->counts.functions -= count - kept;
  shard->counts.duplicates += count - kept;
  m.current = nullptr;
}

}  // namespace nlg
