#include "validate/generators/telling_functions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace nlg {
namespace {

constexpr int kSize = 24;

// One function: solid where x > 0.5, else seen where y > 0, else occluded. 1 near the plane z = 0, which thus tells most, and
// the bare tent elsewhere.
FunctionSet cutByWall() {
  FunctionSet set;
  set.point_count = kSupportPointCount;
  set.scene_idx = {0};
  set.phi.assign(kSupportPointCount, 0);
  set.validity.assign(kSupportPointCount / 8, 0);
  set.seen.assign(kSupportPointCount / 8, 0);
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = supportPattern().points[p];
    if (point[0] > 0.5f) continue;
    set.phi[p] = std::abs(point[2]) < 0.08f ? 255 : static_cast<uint8_t>(std::lround(255.0 * tent(point)));
    set.validity[p / 8] = static_cast<uint8_t>(set.validity[p / 8] | 1 << p % 8);
    if (point[1] > 0.0f) set.seen[p / 8] = static_cast<uint8_t>(set.seen[p / 8] | 1 << p % 8);
  }
  return set;
}

TEST(Slice, ShowsSolidOccludedAndPlainSightWhereTheyAre) {
  const FunctionSet set = cutByWall();
  const Representation representation = Representation::productField(3);
  const std::vector<float> theta(representation.thetaCount(), 0.0f);
  const Slice slice = makeSlice(set, 0, representation, theta.data(), kSize);
  ASSERT_EQ(slice.axis, 2);
  ASSERT_EQ(slice.seen.size(), size_t{kSize} * kSize);
  ASSERT_EQ(slice.valid.size(), slice.seen.size());
  // support points are at most this far from any pixel of the inner part; nearer to a border either side may be nearest
  constexpr float kApart = 0.15f;
  std::array<int, 3> found{};
  for (int i = 0; i < kSize * kSize; ++i) {
    const auto at = [](int pixel) { return 2.0f * (static_cast<float>(pixel) + 0.5f) / kSize - 1.0f; };
    const float from_wall = at(i % kSize) - 0.5f, from_occluded = at(i / kSize);
    if (std::abs(from_wall) < kApart || std::abs(from_occluded) < kApart) continue;
    const bool solid = from_wall > 0.0f, seen = !solid && from_occluded > 0.0f;
    EXPECT_EQ(slice.valid[i], !solid) << "pixel " << i;
    EXPECT_EQ(slice.seen[i], seen) << "pixel " << i;
    ++found[solid ? 0 : seen ? 1 : 2];
  }
  EXPECT_GT(*std::min_element(found.begin(), found.end()), 0) << found[0] << " solid, " << found[1] << " seen, " << found[2];
}

}  // namespace
}  // namespace nlg
