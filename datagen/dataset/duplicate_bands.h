// Which functions of many shards duplicate others, in as much memory as is given: for sets whose sketches do not fit.
//
// Functions are taken in bands of their sketches' sums, the lowest first, and inside a band in the order of the shards. One that
// duplicates a function taken before is a duplicate. Sums of duplicates lie near each other (DuplicateIndex), so that a band needs
// what lies below it no further down than their reach: the sketches of a band and of that reach are all that is ever in memory. Half
// of the memory is for the band; the reach below has the other half as long as sums are spread more widely than a band (at the default
// rule it is 1/500 of all sums). With one band this is the order of the shards. As exact as DuplicateIndex: no two functions that are left duplicate each other, and every other has
// its like among them; which of several duplicates is left depends on the order.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace nlg {

// At most so much of the memory goes to a function: its sketch, and its share of the cells that it is searched by.
inline constexpr uint64_t kDuplicateBytesAFunction = 160;

// shards         read once from the first to the last
// memory_bytes   for sketches; a sum that more functions have than fit is a band of its own all the same
// folder         for nameless files: 88 bytes a function for its sketch, and its samples, deflated (packed_functions.h)
// returns        one entry a function, in the order of the shards
// throws         InputError as readShard does, and when shards have different rules; OutputError when the folder has no room
std::vector<bool> findDuplicates(const std::vector<std::string>& shards, uint64_t memory_bytes, const std::string& folder);

}  // namespace nlg
