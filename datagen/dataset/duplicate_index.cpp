#include "datagen/dataset/duplicate_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kMaxGroupPoints = 256;  // 256 * 255 fits 16 bits; a group of more points sums its first 256

int64_t floorDivide(int64_t a, int64_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

// 16 bits a coordinate.
uint64_t cellKey(const std::array<int64_t, 4>& cell) {
  uint64_t key = 0;
  for (const int64_t c : cell) key = key << 16 | (static_cast<uint64_t>(c) & 0xffff);
  return key;
}

}  // namespace

DuplicateIndex::DuplicateIndex(const DuplicateRule& rule, int point_count, Fetch fetch)
    : rule_(rule), point_count_(point_count), fetch_(std::move(fetch)) {
  NLG_CHECK(point_count % 8, ==, 0);
  // duplicates: sum of squared differences <= rms^2 P =: D^2
  const double squared = rule.rms * rule.rms * point_count;
  // a signed sum over at most P points: |difference| <= sqrt(P) D = rms P; one more for rounding
  reach_ = rule.rms == 0.0 ? 0 : static_cast<int64_t>(std::ceil(rule.rms * point_count)) + 1;
  cell_width_ = std::max<int64_t>({2 * reach_, point_count / 4, 1});
  // sums over groups of n points: sum of (difference of sum)^2 <= n D^2
  max_squared_distance_ = rule.rms == 0.0 ? 0 : static_cast<uint64_t>(std::ceil(kMaxGroupPoints * squared)) + 1;
}

DuplicateIndex::Entry DuplicateIndex::sketch(const FunctionSamples& function) const {
  Entry entry{};
  for (int g = 0; g < kGroupCount; ++g) {
    const int first = static_cast<int>(int64_t{g} * point_count_ / kGroupCount);
    const int end = static_cast<int>(int64_t{g + 1} * point_count_ / kGroupCount);
    uint32_t sum = 0;
    for (int i = first; i < std::min(end, first + kMaxGroupPoints); ++i) sum += function.phi[i];
    entry.group_sums[static_cast<size_t>(g)] = static_cast<uint16_t>(sum);
  }
  int valid_count = 0;
  for (int i = 0; i < point_count_ / 8; ++i) valid_count += std::popcount(function.validity[i]);
  // 65536 valid points of 65536 do not fit: all of them and one less look the same, which only lets one more through
  entry.valid_count = static_cast<uint16_t>(std::min(valid_count, 65535));
  return entry;
}

// The sum over all groups, and the differences between the halves along each axis: groups are octants of the support in fours.
DuplicateIndex::Sums DuplicateIndex::signedSums(const Entry& entry) {
  Sums sums{};
  for (int g = 0; g < kGroupCount; ++g) {
    const int64_t sum = entry.group_sums[static_cast<size_t>(g)];
    const int octant = g / 4;
    sums[0] += sum;
    for (int axis = 0; axis < 3; ++axis) sums[static_cast<size_t>(axis) + 1] += (octant >> axis & 1) != 0 ? -sum : sum;
  }
  return sums;
}

bool DuplicateIndex::mayMatch(const Entry& a, const Entry& b) const {
  if (static_cast<uint64_t>(std::abs(int{a.valid_count} - int{b.valid_count})) > rule_.validity_points) return false;
  uint64_t squared = 0;
  for (size_t g = 0; g < kGroupCount; ++g) {
    const int64_t difference = int64_t{a.group_sums[g]} - int64_t{b.group_sums[g]};
    squared += static_cast<uint64_t>(difference * difference);
  }
  return squared <= max_squared_distance_;
}

std::optional<DuplicateIndex::Match> DuplicateIndex::findInCell(uint64_t cell, const Entry& entry,
                                                                const FunctionSamples& function) {
  const auto found = cells_.find(cell);
  if (found == cells_.end()) return std::nullopt;
  for (const Entry& other : found->second) {
    if (!mayMatch(entry, other)) continue;
    ++compared_count_;
    const std::optional<double> distance = duplicateDistance(rule_, function, fetch_(other.id), point_count_);
    if (distance) return Match{other.id, *distance};
  }
  return std::nullopt;
}

std::optional<DuplicateIndex::Match> DuplicateIndex::findOrAdd(const FunctionSamples& function) {
  Entry entry = sketch(function);
  const Sums sums = signedSums(entry);
  std::array<int64_t, kSumCount> home{}, low{}, high{};
  for (size_t i = 0; i < kSumCount; ++i) {
    home[i] = floorDivide(sums[i], cell_width_);
    low[i] = floorDivide(sums[i] - reach_, cell_width_);
    high[i] = floorDivide(sums[i] + reach_, cell_width_);
  }
  // the function's own cell first: most matches lie there
  std::optional<Match> match = findInCell(cellKey(home), entry, function);
  for (std::array<int64_t, kSumCount> cell = low; !match;) {
    if (cell != home) match = findInCell(cellKey(cell), entry, function);
    size_t i = 0;
    for (; i < kSumCount && cell[i] == high[i]; ++i) cell[i] = low[i];
    if (i == kSumCount) break;
    ++cell[i];
  }
  if (match) return match;
  NLG_CHECK(function_count_, <, uint64_t{std::numeric_limits<uint32_t>::max()});
  entry.id = static_cast<uint32_t>(function_count_++);
  cells_[cellKey(home)].push_back(entry);
  return std::nullopt;
}

}  // namespace nlg
