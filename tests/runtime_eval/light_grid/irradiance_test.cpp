#include "runtime_eval/light_grid/irradiance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/runtime_eval/counting_new.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

TEST(Irradiance, IsTheNormalisedBlendOfTheProbesLight) {
  int64_t of_status[4] = {};
  for (uint64_t seed = 0; seed < 6; ++seed) {
    LightGrid grid = litGrid(randomTree(seed).tree, seed);
    Random random(seed);
    // in every other grid nearly all probes stand in solid
    for (uint32_t& function : grid.probe_function) function = seed % 2 == 1 && random.chance(0.8) ? kNoWeight : function;
    for (int i = 0; i < 2000; ++i) {
      const PositionM at = randomPosition(grid.tree.frame(), random);
      const std::array<float, 3> normal = randomDirection(random);
      float rgb[3];
      const LightStatus status = lookUpIrradiance(grid, at, normal.data(), rgb);
      ++of_status[static_cast<int>(status)];
      ProbeWeights weights;
      if (!lookUpWeights(grid, at, &weights)) {
        ASSERT_EQ(status, LightStatus::outside);
        continue;
      }
      ASSERT_EQ(status, weights.count == 0         ? LightStatus::unlit
                        : weights.certainty < 1.0f ? LightStatus::faint
                                                   : LightStatus::lit);
      double sum = 0.0, expected[3] = {}, magnitude[3] = {};
      const std::array<float, kShCount> basis = shBasis(normal[0], normal[1], normal[2]);
      for (int k = 0; k < weights.count; ++k) sum += double{weights.weight[k]};
      for (int k = 0; k < weights.count; ++k) {
        for (int j = 0; j < kShFloats; ++j) {
          const double term = weights.certainty * weights.weight[k] / sum * kCosineBand[j / 3] * basis[j / 3] *
                              grid.probeLight(weights.probe[k])[j];
          expected[j % 3] += term;
          magnitude[j % 3] += std::abs(term);
        }
      }
      // shares: 9 roundings; products and sums of 8 probes: 9; of 9 coefficients: 11
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(rgb[c], std::max(0.0, expected[c]), 29 * kFloatRounding * magnitude[c]) << lightStatusName(status);
    }
  }
  EXPECT_GT(of_status[static_cast<int>(LightStatus::lit)], 1000);
  EXPECT_GT(of_status[static_cast<int>(LightStatus::faint)], 0);
  EXPECT_GT(of_status[static_cast<int>(LightStatus::unlit)], 0);
  EXPECT_GT(of_status[static_cast<int>(LightStatus::outside)], 100);
}

TEST(Irradiance, OfLinearLightIsLinearInFreeSpace) {
  LightGrid grid = litGrid(randomTree(4).tree, 4);
  std::fill(grid.probe_function.begin(), grid.probe_function.end(), kFreeSpace);
  std::fill(grid.light.begin(), grid.light.end(), 0.0f);
  const ProbeTreeFrame& frame = grid.tree.frame();
  const auto field = [&](const PositionM& at, int channel) {
    double value = 1.0 + channel;
    for (int axis = 0; axis < 3; ++axis) value += 0.01 * (axis + 1) * (at[axis] - frame.first_m[axis]) / frame.spacing_m;
    return value;
  };
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    for (int c = 0; c < 3; ++c)
      grid.light[probe * kShFloats + static_cast<size_t>(c)] = static_cast<float>(field(grid.tree.probePosition(probe), c));
  }
  Random random(4);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const PositionM at = randomPosition(frame, random);
    const std::array<float, 3> normal = randomDirection(random);
    float rgb[3];
    if (lookUpIrradiance(grid, at, normal.data(), rgb) != LightStatus::lit) continue;
    // pi times Y00 is sqrt(pi) / 2; values up to 11, 30 roundings
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[c], field(at, c) * 0.886226925, 30 * kFloatRounding * 11);
    ++found;
  }
  EXPECT_GT(found, 500);
}

TEST(Irradiance, FadesToNothingWhereNoWeightIsBelieved) {
  // halfway from one residue to two, and below
  for (const float share : {1.5f, 0.5f}) {
    LightGrid grid = litGrid(smallTree(), 1);
    Theta theta(ThetaLayout::count);
    theta[ThetaLayout::b3] = share * kResidue;
    std::fill(grid.probe_function.begin(), grid.probe_function.end(), grid.addFunction(1, theta.data()));
    LightGrid free = grid;
    std::fill(free.probe_function.begin(), free.probe_function.end(), kFreeSpace);
    Random random(1);
    int found = 0;
    for (int i = 0; i < 1000; ++i) {
      const PositionM at = randomPosition(grid.tree.frame(), random);
      const float up[3] = {0, 0, 1};
      float rgb[3], expected[3];
      const LightStatus status = lookUpIrradiance(grid, at, up, rgb);
      if (lookUpIrradiance(free, at, up, expected) == LightStatus::outside) continue;
      ASSERT_EQ(status, share > 1.0f ? LightStatus::faint : LightStatus::unlit);
      // v is off by a rounding, the certainty by 12 over the residue, and weights below kLeastWeight of tents are left out: 8 of them
      // are of a sum of kResidue / 2
      const double bound = 12 * kFloatRounding / kResidue + 8 * double{kLeastWeight} / (0.5 * kResidue);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[c], std::max(0.0f, share - 1.0f) * expected[c], bound * 16);
      ++found;
    }
    EXPECT_GT(found, 100);
  }
}

TEST(Irradiance, IsNothingWhereNoProbeHasWeightOrTheGridNoLight) {
  LightGrid without_weight = litGrid(smallTree(), 1), without_light = randomGrid(smallTree(), 1);
  std::fill(without_weight.probe_function.begin(), without_weight.probe_function.end(), kNoWeight);
  Random random(1);
  int found = 0;
  for (int i = 0; i < 1000; ++i) {
    const PositionM at = randomPosition(without_weight.tree.frame(), random);
    const float up[3] = {0, 0, 1};
    for (const LightGrid* grid : {&without_weight, &without_light}) {
      float rgb[3] = {1, 1, 1};
      const LightStatus status = lookUpIrradiance(*grid, at, up, rgb);
      ASSERT_EQ(rgb[0] + rgb[1] + rgb[2], 0.0f);
      ASSERT_TRUE(status == LightStatus::outside || status == LightStatus::unlit);
      found += status == LightStatus::unlit;
    }
  }
  EXPECT_GT(found, 200);
}

TEST(Irradiance, OutsideIsThatOfTheNearestCellWithinOneUnit) {
  const LightGrid grid = litGrid(smallTree(), 2);
  const ProbeTreeFrame& frame = grid.tree.frame();
  const auto at = [&](double x) { return positionAt(frame, {x, 20.25, 20.5}); };
  const float up[3] = {0, 0, 1};
  float border[3], rgb[3];
  ASSERT_NE(lookUpIrradiance(grid, at(0.0), up, border), LightStatus::outside);
  ASSERT_GT(border[0], 0.0f);
  for (const double x : {-0.001, -0.5, -0.999}) {
    EXPECT_EQ(lookUpIrradiance(grid, at(x), up, rgb), LightStatus::outside) << x;
    for (int c = 0; c < 3; ++c) EXPECT_EQ(rgb[c], border[c]) << x;
  }
  for (const double x : {-1.001, -1e300, 66.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_EQ(lookUpIrradiance(grid, at(x), up, rgb), LightStatus::outside) << x;
    EXPECT_EQ(rgb[0] + rgb[1] + rgb[2], 0.0f) << x;
  }
  EXPECT_EQ(lookUpIrradiance(LightGrid{}, {0, 0, 0}, up, rgb), LightStatus::outside);
}

TEST(Irradiance, NeedsADirection) {
  const LightGrid grid = litGrid(smallTree(), 2);
  const PositionM at = positionAt(grid.tree.frame(), {1.0, 20.25, 20.5});
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    for (const float value : {nan, infinity, -infinity, 1e30f, -1.6f}) {
      float normal[3] = {0, 0, 0}, rgb[3] = {1, 1, 1};
      normal[axis] = value;
      EXPECT_EQ(lookUpIrradiance(grid, at, normal, rgb), LightStatus::unlit) << value;
      EXPECT_EQ(rgb[0] + rgb[1] + rgb[2], 0.0f) << value;
    }
  }
}

TEST(Irradiance, IsNeverBelowZero) {
  LightGrid grid = litGrid(smallTree(), 2);
  for (size_t i = 0; i < grid.light.size(); ++i) {
    if (i % kShFloats == 0) grid.light[i] = -1.0f;                   // red all round
    if (i % kShFloats == 2 * kShChannels + 1) grid.light[i] = 9.0f;  // green from above
  }
  const PositionM at = positionAt(grid.tree.frame(), {1.0, 20.25, 20.5});
  const float down[3] = {0, 0, -1};
  float rgb[3];
  ASSERT_NE(lookUpIrradiance(grid, at, down, rgb), LightStatus::outside);
  EXPECT_EQ(rgb[0], 0.0f);
  EXPECT_EQ(rgb[1], 0.0f);
  EXPECT_GT(rgb[2], 0.0f);
}

TEST(Irradiance, StaysFiniteUpToTheLargestLight) {
  LightGrid grid = litGrid(smallTree(), 2);
  for (float& value : grid.light) value = value < 0 ? -kMaxGridLight : kMaxGridLight;
  ASSERT_TRUE(checkLightGrid(grid).ok());
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    float rgb[3];
    lookUpIrradiance(grid, randomPosition(grid.tree.frame(), random), randomDirection(random).data(), rgb);
    for (const float value : rgb) ASSERT_TRUE(std::isfinite(value) && value >= 0.0f);
  }
}

TEST(Irradiance, AllocatesNothing) {
  const LightGrid grid = litGrid(smallTree(), 3);
  Random random(3);
  const long before = allocationCount();
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) {
    float rgb[3];
    lookUpIrradiance(grid, randomPosition(grid.tree.frame(), random), randomDirection(random).data(), rgb);
    sum += double{rgb[0]};
  }
  EXPECT_EQ(allocationCount(), before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace nlg
