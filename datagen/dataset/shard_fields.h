// The counts of a shard, listed once, as function_rows.h lists its arrays.
#pragma once

#include <cstdint>

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
  visit("count_solid_functions", counts.solid_functions);
}

}  // namespace nlg
