// Weighting functions in memory: arrays of rows, and the counts of what was left out of them.
#pragma once

#include <cstdint>
#include <vector>

#include "nlg/support.h"

namespace nlg {

// Arrays of functions, one row a function: the content of a shard, in blocks and chunks.
//
// The arrays are listed once, in forEachArray: whatever writes, reads, checks, moves or appends rows walks that list.

// Bits of FunctionRows::flags, one byte a function.
enum FunctionFlag : uint8_t {
  kFlagOpenShell = 1,  // rays for validity disagreed: open, flipped or self-intersecting geometry near by
  kFlagFewSeen = 2,    // the probe sees less than one support point in a hundred
  kFlagInSolid = 4,    // the probe is in solid, and sees what its eye in air sees
};

// N functions, P support points in pattern order, U test points (0 for training).
struct FunctionRows {
  int point_count = 0;       // P
  int test_point_count = 0;  // U

  std::vector<uint8_t> phi;              // N x P, round(255 phi)
  std::vector<uint8_t> validity;         // N x P/8, bit i of byte b is point 8 b + i
  std::vector<uint8_t> seen;             // N x P/8, points that the probe sees
  std::vector<uint8_t> blend_sum;        // N x P, StoredFunction::blend_sum; 255 where the function is 0
  std::vector<double> probe_position_m;  // N x 3, world
  std::vector<float> spacing_m;          // N
  std::vector<uint8_t> flags;            // N, FunctionFlag

  std::vector<uint8_t> phi_test;       // N x U
  std::vector<uint8_t> validity_test;  // N x U/8
  std::vector<uint8_t> seen_test;      // N x U/8

  uint64_t functionCount() const { return flags.size(); }
};

// Values a function that an array holds.
inline uint64_t rowWidth(const std::vector<uint64_t>& columns) { return columns.empty() ? 1 : columns[0]; }

// Calls visit(dataset name, array of each of the rows, columns) for every array; columns none: one value a function, no second
// dimension. All rows have the shape of the first.
template <class Visit, class Rows, class... MoreRows>
void forEachArray(const Visit& visit, Rows& rows, MoreRows&... more) {
  const auto P = static_cast<uint64_t>(rows.point_count);
  const auto U = static_cast<uint64_t>(rows.test_point_count);
  visit("phi", std::vector<uint64_t>{P}, rows.phi, more.phi...);
  visit("validity", std::vector<uint64_t>{P / 8}, rows.validity, more.validity...);
  visit("seen", std::vector<uint64_t>{P / 8}, rows.seen, more.seen...);
  visit("blend_sum", std::vector<uint64_t>{P}, rows.blend_sum, more.blend_sum...);
  visit("probe_position_m", std::vector<uint64_t>{3}, rows.probe_position_m, more.probe_position_m...);
  visit("spacing_m", std::vector<uint64_t>{}, rows.spacing_m, more.spacing_m...);
  visit("flags", std::vector<uint64_t>{}, rows.flags, more.flags...);
  visit("phi_test", std::vector<uint64_t>{U}, rows.phi_test, more.phi_test...);
  visit("validity_test", std::vector<uint64_t>{U / 8}, rows.validity_test, more.validity_test...);
  visit("seen_test", std::vector<uint64_t>{U / 8}, rows.seen_test, more.seen_test...);
}

// Rows of the same shape, none of them yet.
FunctionRows emptyLike(const FunctionRows& rows);

// The n-th function; good as long as the arrays are.
StoredFunction functionAt(const FunctionRows& rows, uint64_t n);

// Appends functions [first, first + count) to rows of the same shape.
void appendRows(const FunctionRows& from, uint64_t first, uint64_t count, FunctionRows* to);

// Appends a function of zeros.
void appendZeros(FunctionRows* rows);

// Takes memory for so many functions in all.
void reserveRows(uint64_t count, FunctionRows* rows);

// Moves function `from` to the place of function `to`, which is lost; drops all functions behind the first `count`.
void moveRow(uint64_t from, uint64_t to, FunctionRows* rows);
void truncateRows(uint64_t count, FunctionRows* rows);

// What a shard left out, and why; every visited probe is counted exactly once among functions, free_space, in_solid, duplicates,
// empty and outside.
struct ShardCounts {
  uint64_t grid_probes = 0;     // probes of the whole grid
  uint64_t visited_probes = 0;  // of these were looked at (max_functions may stop earlier)
  uint64_t functions = 0;       // stored: N
  uint64_t free_space = 0;      // no triangle in the support: the bare tent
  uint64_t in_solid = 0;        // the probe itself lies in solid, and has no function
  uint64_t duplicates = 0;      // by the shard's duplicate rule, of an earlier function of the shard
  uint64_t empty = 0;           // phi is zero at every support point
  // Not an outcome of its own: probes in solid that got a function all the same, seen from an eye in air, before duplicates are
  // left out.
  uint64_t solid_functions = 0;
  uint64_t outside = 0;  // no place of the support lies within the level's hull (datagen/visibility/hull.h)
};

}  // namespace nlg
