#include "export/engine/light_volume.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "export/engine/engine_format.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"

namespace nlg {
namespace {

std::vector<std::string> texts(const std::array<double, 6>& numbers) {
  std::vector<std::string> result(numbers.size());
  std::transform(numbers.begin(), numbers.end(), result.begin(), [](double number) { return std::to_string(number); });
  return result;
}

// Of freeGrid: below 48 units of a root of 64 along z; 0.5 m a unit, from (-3, 10000, 0.25).
TEST(VolumeBox, IsTheUsedCellsAndATexelOnEverySide) {
  const LightBox box = volumeBox(freeGrid(), {{}, 1.0});
  EXPECT_EQ(box.low_m, (PositionM{-4.0, 9999.0, -0.75}));
  EXPECT_EQ(box.high_m[0], -3.0 + 32.0 + 1.0);
  EXPECT_EQ(box.texel_count[0], 34u);
  EXPECT_EQ(volumeBox(freeGrid(), {}).texel_count[0], 2 * 64u + 2) << "half a unit, where nothing is said";
}

TEST(VolumeBox, TakesAnExtentAsItIsWithTexelsNoWiderThanAsked) {
  const LightBox box = volumeBox(freeGrid(), {texts({0, 10001, 1, 3, 10002, 1.5}), 0.4});
  EXPECT_EQ(box.low_m, (PositionM{0, 10001, 1}));
  EXPECT_EQ(box.high_m, (PositionM{3, 10002, 1.5}));
  EXPECT_EQ(box.texel_count, (TextureSize{8, 3, 2}));
}

// Walls, cells that were left out, and the border must not darken what a linear filter reads beside them.
TEST(LightVolume, StaysConstantWhereAllProbesHoldTheSame) {
  LightGrid grid = everyRepresentation(ThetaPrecision::int8, 3);
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    for (size_t i = 0; i < kShFloats; ++i) grid.light[probe * kShFloats + i] = static_cast<float>(i + 1);
  }
  const LightVolume volume = makeLightVolume(grid, volumeBox(grid, {{}, 2.0}));
  EXPECT_EQ(volume.lit + volume.filled, volume.box.texelCount());
  EXPECT_GT(volume.filled, 100u);
  for (size_t i = 0; i < volume.light.size(); ++i) {
    const auto expected = static_cast<float>(i % kShFloats + 1);
    ASSERT_NEAR(volume.light[i], expected, 1e-5f * expected) << i / kShFloats;
  }
}

TEST(LightVolume, KeepsTheGridsLightWhereThereIsSome) {
  const LightGrid grid = freeGrid();
  const LightBox box = volumeBox(grid, {{}, 1.0});
  const LightVolume volume = makeLightVolume(grid, box);
  LookUpScratch scratch;
  const ResampledLight resampled = resampleLight(grid, box, &scratch);
  for (size_t texel = 0; texel < resampled.status.size(); ++texel) {
    if (resampled.status[texel] != LightStatus::lit) continue;
    for (size_t i = texel * kShFloats; i < (texel + 1) * kShFloats; ++i) ASSERT_EQ(volume.light[i], resampled.light[i]);
  }
}

TEST(LightVolume, FillsFromWhatIsNearest) {
  // cells end at 48 units, z = 24.25 m: two texels lie in them, one near, and the others are dark
  const LightVolume volume = makeLightVolume(freeGrid(), {{0, 10010, 22}, {1, 10011, 32}, {1, 1, 10}});
  ASSERT_EQ(volume.lit, 3u);
  EXPECT_EQ(volume.filled, 7u);
  for (size_t texel = volume.lit; texel < 10; ++texel) {
    for (size_t i = 0; i < kShFloats; ++i)
      EXPECT_EQ(volume.light[texel * kShFloats + i], volume.light[(volume.lit - 1) * kShFloats + i]) << texel;
  }
}

TEST(LightVolume, IsDarkWhereNothingIsLit) {
  const LightVolume volume = makeLightVolume(freeGrid(), {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
  EXPECT_EQ(volume.lit + volume.filled, 0u);
  EXPECT_EQ(largestLight(volume), 0.0f);
}

TEST(Texture3d, IsReadAsGpusRead) {
  const Texture3d texture = {{2, 1, 2}, {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}, {12, 13, 14, 15}}};
  EXPECT_EQ(sampleLinear(texture, {0.25, 0.5, 0.25}), (Rgba{0, 1, 2, 3})) << "a texel's centre";
  EXPECT_EQ(sampleLinear(texture, {0.5, 0.1, 0.25}), (Rgba{2, 3, 4, 5})) << "between two";
  EXPECT_EQ(sampleLinear(texture, {0.5, 0.9, 0.5}), (Rgba{6, 7, 8, 9})) << "between four";
  EXPECT_EQ(sampleLinear(texture, {-3.0, 0.0, 9.0}), (Rgba{8, 9, 10, 11})) << "clamped to the edge";
}

TEST(ResamplingError, IsNoneOfTheLookUpItself) {
  const LightGrid grid = everyRepresentation(ThetaPrecision::int8, 3);
  const auto exact = [&](const PositionM& position_m, const float* normal_3) {
    std::array<float, 3> rgb;
    lookUpIrradiance(grid, position_m, normal_3, rgb.data());
    return rgb;
  };
  const std::optional<ResamplingError> error = resamplingError(grid, nullptr, exact, 1000);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->places, 1000);
  EXPECT_EQ(error->rmse + error->p95 + error->axes_rmse + error->axes_p95, 0.0);
}

TEST(ResamplingError, IsAShareOfTheLight) {
  const LightGrid grid = everyRepresentation(ThetaPrecision::int8, 3);
  const auto too_bright = [&](const PositionM& position_m, const float* normal_3) {
    std::array<float, 3> rgb;
    lookUpIrradiance(grid, position_m, normal_3, rgb.data());
    for (float& channel : rgb) channel *= 1.25f;
    return rgb;
  };
  const std::optional<ResamplingError> error = resamplingError(grid, nullptr, too_bright, 1000);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->rmse, 0.25, 1e-6);
  EXPECT_NEAR(error->axes_rmse, 0.25, 1e-6);
  EXPECT_GT(error->p95, error->rmse);
}

}  // namespace
}  // namespace nlg
