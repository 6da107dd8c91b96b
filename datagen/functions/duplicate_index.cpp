#include "datagen/functions/duplicate_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <numeric>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kBlock = 512;  // points between two looks at whether the sum is too large already

uint32_t squaredDifference(const uint8_t* a, const uint8_t* b, int count) {
  uint32_t sum = 0;
  for (int i = 0; i < count; ++i) {
    const int difference = int{a[i]} - int{b[i]};
    sum += static_cast<uint32_t>(difference * difference);
  }
  return sum;
}

// Bits set in what `combine` makes of two rows of validity, 64 at a time: most pairs are told apart here, and without an instruction
// for it a popcount is a call.
template <class Combine>
uint64_t countBits(const uint8_t* a, const uint8_t* b, int byte_count, const Combine& combine) {
  uint64_t count = 0;
  for (int i = 0; i < byte_count; i += 8) {
    uint64_t words[2] = {};
    const size_t bytes = static_cast<size_t>(std::min(8, byte_count - i));
    std::memcpy(&words[0], a + i, bytes);
    std::memcpy(&words[1], b + i, bytes);
    if (const uint64_t bits = combine(words[0], words[1]); bits != 0) count += static_cast<uint64_t>(std::popcount(bits));
  }
  return count;
}

constexpr uint64_t kMaxPointCount = 65536;
constexpr int kMaxGroupPoints = 256;  // 256 * 255 fits 16 bits; a group of more points sums its first 256

// Two cells of one key only make a search longer.
template <class Cell>
uint64_t cellKey(const Cell& cell) {
  uint64_t key = 0;
  for (const int64_t c : cell) key = (key ^ static_cast<uint64_t>(c)) * 0x9e3779b97f4a7c15u + (key >> 29);
  return key;
}

}  // namespace

std::optional<double> duplicateDistance(const DuplicateRule& rule, const StoredFunction& a, const StoredFunction& b,
                                        int point_count) {
  const int bytes = point_count / 8;
  if (countBits(a.validity, b.validity, bytes, std::bit_xor<uint64_t>()) > rule.validity_points) return std::nullopt;
  const uint64_t valid_in_both = countBits(a.validity, b.validity, bytes, std::bit_and<uint64_t>());
  const double limit = rule.rms * rule.rms * static_cast<double>(valid_in_both);
  uint64_t sum = 0;
  for (int i = 0; i < point_count; i += kBlock) {
    sum += squaredDifference(a.phi + i, b.phi + i, std::min(kBlock, point_count - i));
    if (static_cast<double>(sum) > limit) return std::nullopt;
  }
  return valid_in_both == 0 ? 0.0 : std::sqrt(static_cast<double>(sum) / static_cast<double>(valid_in_both));
}

DuplicateIndex::DuplicateIndex(const DuplicateRule& rule, int point_count, Fetch fetch)
    : rule_(rule), point_count_(point_count), fetch_(std::move(fetch)) {
  NLG_CHECK(point_count % 8, ==, 0);
  // duplicates: sum of squared differences <= rms^2 P =: D^2
  const double squared = rule.rms * rule.rms * point_count;
  // the validity of duplicates differs in few points, in an octant as in all; cells are wide enough that a search seldom leaves
  // its own, and one of all points splits what octants leave together
  const auto validity_reach = static_cast<int64_t>(std::min<uint64_t>(rule.validity_points, kMaxPointCount));
  reach_.fill(validity_reach);
  cell_width_.fill(std::max<int64_t>({2 * validity_reach, point_count / 32, 1}));
  cell_width_[kOctantCount] = std::max<int64_t>({2 * validity_reach, point_count / 128, 1});
  // a sum over at most P points: |difference| <= sqrt(P) D = rms P; one more for rounding
  reach_.back() = rule.rms == 0.0 ? 0 : static_cast<int64_t>(std::ceil(rule.rms * point_count)) + 1;
  cell_width_.back() = std::max<int64_t>({2 * reach_.back(), point_count / 4, 1});
  // sums over groups of n points: sum of (difference of sum)^2 <= n D^2
  max_squared_distance_ = rule.rms == 0.0 ? 0 : static_cast<uint64_t>(std::ceil(kMaxGroupPoints * squared)) + 1;
}

DuplicateIndex::Sketch DuplicateIndex::sketch(const StoredFunction& function) const {
  Sketch sketch{};
  for (int g = 0; g < kGroupCount; ++g) {
    const int first = static_cast<int>(int64_t{g} * point_count_ / kGroupCount);
    const int end = static_cast<int>(int64_t{g + 1} * point_count_ / kGroupCount);
    uint32_t sum = 0;
    for (int i = first; i < std::min(end, first + kMaxGroupPoints); ++i) sum += function.phi[i];
    sketch.group_sums[static_cast<size_t>(g)] = static_cast<uint16_t>(sum);
  }
  for (int o = 0; o < kOctantCount; ++o) {
    int valid_count = 0;
    const int end = static_cast<int>(int64_t{o + 1} * (point_count_ / 8) / kOctantCount);
    for (int i = static_cast<int>(int64_t{o} * (point_count_ / 8) / kOctantCount); i < end; ++i) {
      valid_count += std::popcount(function.validity[i]);
    }
    sketch.valid_counts[static_cast<size_t>(o)] = static_cast<uint16_t>(valid_count);
  }
  return sketch;
}

DuplicateIndex::Features DuplicateIndex::features(const Sketch& sketch) {
  Features features{};
  for (size_t o = 0; o < kOctantCount; ++o) {
    features[o] = sketch.valid_counts[o];
    features[kOctantCount] += sketch.valid_counts[o];
  }
  features.back() = std::accumulate(sketch.group_sums.begin(), sketch.group_sums.end(), int64_t{0});
  return features;
}

bool DuplicateIndex::mayMatch(const Sketch& a, const Sketch& b) const {
  uint64_t differing = 0;
  for (size_t o = 0; o < kOctantCount; ++o)
    differing += static_cast<uint64_t>(std::abs(int{a.valid_counts[o]} - int{b.valid_counts[o]}));
  if (differing > rule_.validity_points) return false;
  uint64_t squared = 0;
  for (size_t g = 0; g < kGroupCount; ++g) {
    const int64_t difference = int64_t{a.group_sums[g]} - int64_t{b.group_sums[g]};
    squared += static_cast<uint64_t>(difference * difference);
  }
  return squared <= max_squared_distance_;
}

template <class Visit>
void DuplicateIndex::forEachNear(const Sketch& sketch, const Visit& visit) const {
  const Features place = features(sketch);
  // cells that bounds on duplicates reach: along counts of valid points, by octant and in all, and the sum of samples
  Features home{}, low{}, high{};
  for (size_t i = 0; i < kFeatureCount; ++i) {
    home[i] = place[i] / cell_width_[i];
    low[i] = std::max<int64_t>(0, place[i] - reach_[i]) / cell_width_[i];
    high[i] = (place[i] + reach_[i]) / cell_width_[i];
  }
  // the sketch tells most apart before samples are fetched
  const auto visitCell = [&](const Features& cell) {
    const auto found = cells_.find(cellKey(cell));
    if (found == cells_.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(),
                       [&](const Entry& other) { return mayMatch(sketch, other) && visit(other); });
  };
  // the own cell first: most duplicates lie in it. Then the others, counted like an odometer
  bool done = visitCell(home);
  for (Features cell = low; !done;) {
    if (cell != home) done = visitCell(cell);
    size_t i = 0;
    for (; i < kFeatureCount && cell[i] == high[i]; ++i) cell[i] = low[i];
    if (i == kFeatureCount) break;
    ++cell[i];
  }
}

std::optional<DuplicateIndex::Match> DuplicateIndex::compare(const StoredFunction& function, uint64_t id) {
  ++compared_count_;
  const std::optional<double> distance = duplicateDistance(rule_, function, fetch_(id), point_count_);
  if (!distance) return std::nullopt;
  return Match{id, *distance};
}

std::optional<DuplicateIndex::Match> DuplicateIndex::findOrAdd(const StoredFunction& function) {
  const Sketch place = sketch(function);
  std::optional<Match> match;
  forEachNear(place, [&](const Entry& other) { return (match = compare(function, other.id)).has_value(); });
  if (!match) add(place);
  return match;
}

void DuplicateIndex::add(const Sketch& sketch) {
  NLG_CHECK(function_count_, <, uint64_t{std::numeric_limits<uint32_t>::max()});
  Features cell = features(sketch);
  for (size_t i = 0; i < kFeatureCount; ++i) cell[i] /= cell_width_[i];
  cells_[cellKey(cell)].push_back({sketch, static_cast<uint32_t>(function_count_++)});
}

void DuplicateIndex::forEachMatch(const StoredFunction& function, const std::function<bool(uint64_t id)>& isWanted,
                                  const std::function<void(const Match&)>& visit) {
  forEachNear(sketch(function), [&](const Entry& other) {
    if (!isWanted(other.id)) return false;
    if (const auto match = compare(function, other.id)) visit(*match);
    return false;
  });
}

}  // namespace nlg
