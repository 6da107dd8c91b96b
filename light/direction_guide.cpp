#include "light/direction_guide.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "light/directions.h"

namespace nlg {
namespace {

constexpr float kEvenShare = 0.5f;  // of the rays
// What was met fades by as much a place: places follow one another along a curve through the level, twelve a cell.
constexpr float kFading = 0.95f;
constexpr float kUnsureCount = 0.3f;  // rays of mean radiance that every bin begins with: one that none met is not yet dark
constexpr float kBesideBright =
    0.5f;  // of a bin's radiance, for those beside it: what is near moves from bin to bin with the place

// The part that x lies in, and where in it, 0..1. ends   rising from 0 to 1, about
template <size_t n>
std::pair<size_t, double> partAt(const std::array<float, n>& ends, double x) {
  const auto end = std::upper_bound(ends.begin() + 1, ends.end() - 1, static_cast<float>(x));
  const double low = *(end - 1);
  return {static_cast<size_t>(end - ends.begin() - 1), std::clamp((x - low) / (*end - low), 0.0, 1.0)};
}

}  // namespace

DirectionGuide::DirectionGuide() { share({}); }

DirectionGuide::Drawn DirectionGuide::draw(double u, double v) const {
  const auto [row, within_row] = partAt(row_ends_, u);
  const auto [column, within_column] = partAt(column_ends_[row], v);
  const size_t bin = row * kColumns + column;
  return {
      sphereDirection((static_cast<double>(row) + within_row) / kRows, (static_cast<double>(column) + within_column) / kColumns),
      share_[bin] * (kBins * 0.25f / std::numbers::pi_v<float>), bin};
}

float DirectionGuide::density(const glm::vec3& direction) const {
  float turn = std::atan2(direction.y, direction.x) * (0.5f / std::numbers::pi_v<float>);
  if (turn < 0.0f) turn += 1.0f;
  const auto part = [](float x, size_t count) {
    return std::min(static_cast<size_t>(std::max(0.0f, x) * static_cast<float>(count)), count - 1);
  };
  const size_t bin = part(0.5f * (1.0f - direction.z), kRows) * kColumns + part(turn, kColumns);
  return share_[bin] * (kBins * 0.25f / std::numbers::pi_v<float>);
}

void DirectionGuide::learn(size_t bin, float radiance) {
  squares_[bin] += radiance * radiance;
  counts_[bin] += 1.0f;
}

void DirectionGuide::endPlace() {
  // over bins, not over rays: most of these go where it is bright
  float mean_square = 0.0f;
  for (size_t b = 0; b < kBins; ++b) mean_square += squares_[b] / std::max(counts_[b], 1e-6f) / kBins;
  Bins radiance;
  for (size_t b = 0; b < kBins; ++b) {
    radiance[b] = std::sqrt((squares_[b] + kUnsureCount * mean_square) / (counts_[b] + kUnsureCount));
    squares_[b] *= kFading;
    counts_[b] *= kFading;
  }
  share(radiance);
}

// By the radiance of each bin and of those beside it.
void DirectionGuide::share(const Bins& radiance) {
  for (size_t b = 0; b < kBins; ++b) {
    const size_t row = b / kColumns, column = b % kColumns;
    const auto at = [&](size_t r, size_t c) { return radiance[r * kColumns + c % kColumns]; };
    const float beside = std::max({at(row, column + 1), at(row, column + kColumns - 1), at(row > 0 ? row - 1 : row, column),
                                   at(row + 1 < kRows ? row + 1 : row, column)});
    share_[b] = std::max(radiance[b], kBesideBright * beside);
  }
  const float sum = std::accumulate(share_.begin(), share_.end(), 0.0f);
  const bool has_light = sum > 0.0f && std::isfinite(sum);  // squares of what no file can hold are beyond a float
  for (float& of_bin : share_) of_bin = (has_light ? kEvenShare + (1.0f - kEvenShare) * of_bin * kBins / sum : 1.0f) / kBins;
  row_ends_[0] = 0.0f;
  for (size_t row = 0; row < kRows; ++row) {
    const auto first = share_.begin() + row * kColumns;
    const float of_row = std::accumulate(first, first + kColumns, 0.0f);
    row_ends_[row + 1] = row_ends_[row] + of_row;
    column_ends_[row][0] = 0.0f;
    for (size_t c = 0; c < kColumns; ++c) column_ends_[row][c + 1] = column_ends_[row][c] + first[c] / of_row;
  }
}

}  // namespace nlg
