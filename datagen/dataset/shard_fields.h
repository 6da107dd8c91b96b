// The fields of a shard, listed once: whatever writes, reads, checks or moves them all walks these lists.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/dataset/shard.h"

namespace nlg {

// Calls visit(attribute name, field) for every count, so that writing and reading cannot list different ones.
template <class Counts, class Visit>
void forEachCount(Counts& counts, const Visit& visit) {
  visit("count_grid_probes", counts.grid_probes);
  visit("count_visited_probes", counts.visited_probes);
  visit("count_functions", counts.functions);
  visit("count_free_space", counts.free_space);
  visit("count_in_solid", counts.in_solid);
  visit("count_duplicates", counts.duplicates);
  visit("count_empty", counts.empty);
}

// Values a function that an array holds.
inline uint64_t rowWidth(const std::vector<uint64_t>& columns) { return columns.empty() ? 1 : columns[0]; }

// Calls visit(dataset name, field, columns) for every array; columns 0: one value a function, no second dimension.
template <class AnyShard, class Visit>
void forEachArray(AnyShard& shard, const Visit& visit) {
  const auto P = static_cast<uint64_t>(shard.point_count);
  const auto U = static_cast<uint64_t>(shard.test_point_count);
  visit("phi", shard.phi, std::vector<uint64_t>{P});
  visit("validity", shard.validity, std::vector<uint64_t>{P / 8});
  visit("seen", shard.seen, std::vector<uint64_t>{P / 8});
  visit("probe_position_m", shard.probe_position_m, std::vector<uint64_t>{3});
  visit("spacing_m", shard.spacing_m, std::vector<uint64_t>{});
  visit("flags", shard.flags, std::vector<uint64_t>{});
  visit("phi_test", shard.phi_test, std::vector<uint64_t>{U});
  visit("validity_test", shard.validity_test, std::vector<uint64_t>{U / 8});
  visit("seen_test", shard.seen_test, std::vector<uint64_t>{U / 8});
}

}  // namespace nlg
