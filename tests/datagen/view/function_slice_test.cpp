#include "datagen/view/function_slice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

// A function made of rules for every support point.
struct MadeFunction {
  std::vector<uint8_t> phi, validity, seen;

  MadeFunction(const std::function<double(const LocalPoint&)>& value, const std::function<PixelKind(const LocalPoint&)>& kind)
      : phi(kSupportPointCount), validity(kValidityByteCount), seen(kValidityByteCount) {
    for (int i = 0; i < kSupportPointCount; ++i) {
      const LocalPoint& point = supportPattern().points[i];
      const PixelKind what = kind(point);
      const auto bit = static_cast<uint8_t>(1 << i % 8);
      if (what == PixelKind::solid) continue;
      validity[i / 8] |= bit;
      if (what == PixelKind::seen) seen[i / 8] |= bit;
      phi[i] = static_cast<uint8_t>(std::lround(255 * value(point)));
    }
  }
  StoredFunction samples() const { return {phi.data(), validity.data(), seen.data()}; }
};

PixelKind alwaysSeen(const LocalPoint&) { return PixelKind::seen; }

glm::dvec3 localOf(const FunctionSlice& slice, size_t pixel) {
  const double x = static_cast<double>(pixel % slice.size), y = static_cast<double>(pixel / slice.size);
  return slice.plane.toLocal({2 * (x + 0.5) / slice.size - 1, 2 * (y + 0.5) / slice.size - 1});
}

TEST(FunctionSlice, OfALinearFunctionIsExactButForRounding) {
  const auto value = [](const LocalPoint& p) { return 0.5 + 0.2 * p[0] - 0.15 * p[1] + 0.1 * p[2]; };
  const MadeFunction function(value, alwaysSeen);
  const std::vector<ViewTriangle> no_triangles;
  for (int normal = 0; normal < 3; ++normal) {
    const FunctionSlice slice = makeFunctionSlice(function.samples(), normal, 64, &no_triangles);
    for (size_t i = 0; i < slice.phi.size(); ++i) {
      const glm::dvec3 p = localOf(slice, i);
      ASSERT_EQ(slice.kind[i], PixelKind::seen);
      // half a step of 8 bits; and in the corners nothing falls below the lowest point, which stands up to 0.1 of slope 0.27 away
      EXPECT_NEAR(slice.phi[i], value({float(p.x), float(p.y), float(p.z)}), 0.03) << p.x << ", " << p.y << ", " << p.z;
    }
  }
}

TEST(FunctionSlice, CarriesNothingThroughAWall) {
  // 1 on this side of a sheet at x = 0.31, 0 behind it
  const auto behind = [](const LocalPoint& p) { return p[0] > 0.31f; };
  const MadeFunction function([&](const LocalPoint& p) { return behind(p) ? 0.0 : 1.0; },
                              [&](const LocalPoint& p) { return behind(p) ? PixelKind::diffused : PixelKind::seen; });
  const std::vector<ViewTriangle> sheet = trianglesNear(thinWall(Sides::two), glm::dvec3(0.0), 1.0, 1.2);
  const std::vector<ViewTriangle> nothing;
  int carried_count = 0;
  for (const int normal : {1, 2}) {
    const FunctionSlice slice = makeFunctionSlice(function.samples(), normal, 96, &sheet);
    const FunctionSlice blind = makeFunctionSlice(function.samples(), normal, 96, &nothing);
    for (size_t i = 0; i < slice.phi.size(); ++i) {
      const bool is_behind = localOf(slice, i).x > 0.31;
      ASSERT_EQ(slice.kind[i], is_behind ? PixelKind::diffused : PixelKind::seen) << localOf(slice, i).x;
      EXPECT_EQ(slice.phi[i], is_behind ? 0.0f : 1.0f) << localOf(slice, i).x;
      carried_count += blind.kind[i] != slice.kind[i];
    }
  }
  EXPECT_GT(carried_count, 0);  // without the sheet some pixels would have been on the wrong side
}

}  // namespace
}  // namespace nlg
