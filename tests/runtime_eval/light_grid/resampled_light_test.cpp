#include "nlg/look_up.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

// The whole box of the roots, and more on every side.
LightBox boxAround(const LightGrid& grid, std::array<uint32_t, 3> texels) {
  const ProbeTreeFrame& frame = grid.tree.frame();
  return {positionAt(frame, {-4, -4, -4}), positionAt(frame, {68, 68, 68}), texels};
}

TEST(ResampledLight, HasItsTexelsHalfATexelInsideTheBox) {
  const LightBox box{{0, 10, -1}, {4, 14, 1}, {2, 4, 1}};
  EXPECT_EQ(box.texelCount(), 8u);
  EXPECT_EQ(box.texelCentre(0, 0, 0), (PositionM{1, 10.5, 0}));
  EXPECT_EQ(box.texelCentre(1, 3, 0), (PositionM{3, 13.5, 0}));
}

TEST(ResampledLight, IsTheLightAtItsTexels) {
  const LightGrid grid = freeGrid();
  LookUpScratch scratch;
  const LightBox box = boxAround(grid, {37, 29, 31});  // more than one piece of 16384
  const ResampledLight resampled = resampleLight(grid, box, &scratch);
  ASSERT_EQ(resampled.light.size(), box.texelCount() * kShFloats);
  ASSERT_EQ(resampled.status.size(), box.texelCount());
  size_t texel = 0, lit = 0;
  for (size_t z = 0; z < 31; ++z) {
    for (size_t y = 0; y < 29; ++y) {
      for (size_t x = 0; x < 37; ++x, ++texel) {
        float light[kShFloats];
        const LightStatus status = lookUpLight(grid, box.texelCentre(x, y, z), light);
        ASSERT_EQ(resampled.status[texel], status) << x << ", " << y << ", " << z;
        lit += status == LightStatus::lit;
        for (size_t i = 0; i < kShFloats; ++i) {
          // coefficients up to 4; shares and sums of 8, as look_up_test.cpp counts them
          ASSERT_NEAR(resampled.light[texel * kShFloats + i], light[i], 40 * 0x1p-24 * 4) << x << ", " << y << ", " << z;
        }
      }
    }
  }
  EXPECT_GT(lit, 1000u);
  EXPECT_LT(lit, box.texelCount());
}

}  // namespace
}  // namespace nlg
