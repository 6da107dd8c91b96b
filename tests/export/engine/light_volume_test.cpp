#include "export/engine/light_volume.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/input_error.h"

namespace nlg {
namespace {

TEST(TexelBox, HasTexelsNoWiderThanAsked) {
  const LightBox box = texelBox({0, 10001, 1}, {3, 10002, 1.5}, 0.4);
  EXPECT_EQ(box.low_m, (PositionM{0, 10001, 1}));
  EXPECT_EQ(box.high_m, (PositionM{3, 10002, 1.5}));
  EXPECT_EQ(box.texel_count, (TextureSize{8, 3, 2}));
}

TEST(TexelBox, RefusesMoreTexelsThanATextureHolds) {
  EXPECT_NE(errorOfCall<UsageError>([] { texelBox({0, 0, 0}, {300, 300, 300}, 1.0); }).find("8388608 texels"), std::string::npos);
  // seven volumes along z, each with a slice more at both ends
  EXPECT_NE(errorOfCall<UsageError>([] { texelBox({0, 0, 0}, {1, 1, 300}, 1.0); }).find("2048"), std::string::npos);
  EXPECT_EQ(texelBox({0, 0, 0}, {1, 1, 290}, 1.0).texel_count[2], 290u);
}

// Rows of three texels, of which one is lit: what a linear filter reads beside it must not be dark.
TEST(FilledVolume, TakesTheMeanOfWhatHadLightBefore) {
  const LightBox box{{0, 0, 0}, {5, 1, 1}, {5, 1, 1}};
  std::vector<float> light(5 * kShFloats, -7.0f);
  std::fill_n(light.begin(), kShFloats, 1.0f);
  std::fill_n(light.begin() + 2 * kShFloats, kShFloats, 2.0f);
  const LightVolume volume = filledVolume(box, light, {1, 0, 1, 0, 0});
  for (const auto& [texel, expected] : {std::pair(0, 1.0f), {1, 1.5f}, {2, 2.0f}, {3, 2.0f}, {4, 2.0f}}) {
    for (int i = 0; i < kShFloats; ++i) EXPECT_EQ(volume.light[static_cast<size_t>(texel * kShFloats + i)], expected) << texel;
  }
}

TEST(FilledVolume, IsDarkWhereNothingIsLit) {
  const LightVolume volume = filledVolume({{0, 0, 0}, {1, 1, 1}, {2, 1, 1}}, std::vector<float>(2 * kShFloats, 3.0f), {0, 0});
  EXPECT_EQ(largestLight(volume), 0.0f);
}

TEST(Texture3d, IsReadAsGpusRead) {
  const Texture3d texture = {{2, 1, 2}, {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}, {12, 13, 14, 15}}};
  EXPECT_EQ(sampleLinear(texture, {0.25, 0.5, 0.25}), (Rgba{0, 1, 2, 3})) << "a texel's centre";
  EXPECT_EQ(sampleLinear(texture, {0.5, 0.1, 0.25}), (Rgba{2, 3, 4, 5})) << "between two";
  EXPECT_EQ(sampleLinear(texture, {0.5, 0.9, 0.5}), (Rgba{6, 7, 8, 9})) << "between four";
  EXPECT_EQ(sampleLinear(texture, {-3.0, 0.0, 9.0}), (Rgba{8, 9, 10, 11})) << "clamped to the edge";
}

}  // namespace
}  // namespace nlg
