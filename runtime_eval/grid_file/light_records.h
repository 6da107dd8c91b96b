// Coder of packed light in a file: each number as its difference from neighbours' numbers, by a range coder.
//
// Probes are in the order of their Morton codes, so that the next probe at lower x, at lower y and at lower z come before a probe. What
// the three hold in the middle is what is expected of it. How far they are apart says how sure that is, and so do the differences of the
// numbers before in the same record: each of the two picks a model of each number, and the mean of what both say is taken.
// A record of darkness is one bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime_eval/light_grid/packed_light.h"

namespace nlg {

// Records that come before one, of probes next to its own; kNoRecord where there is none.
inline constexpr uint32_t kNoRecord = 0xffffffff;
using RecordsBefore = std::array<uint32_t, 3>;

// By probe with a weight, in their order: probes with a weight 1, 2 or 4 units of the lattice below it along x, y and z, the nearest one.
std::vector<RecordsBefore> recordsBefore(const ProbeTree& tree, const std::vector<uint32_t>& probe_function);

// records   as many as packed has probes; of grids with groups of light each group's records have them
std::vector<uint8_t> codedRecords(const PackedLight& packed, const std::vector<RecordsBefore>& before);
// The inverse, for records of these axes; numbers of dark records are 0.
// returns   ok; what checkLightLayout says; tensor_unexpected where these are not the records of so many groups of probes
FileResult decodeRecords(const std::vector<uint8_t>& bytes, const std::vector<RecordsBefore>& before, size_t group_count,
                         PackedLight* packed);

}  // namespace nlg
