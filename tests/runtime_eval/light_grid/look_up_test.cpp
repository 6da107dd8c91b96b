#include "nlg/look_up.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tests/runtime_eval/counting_new.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

constexpr float kUp[3] = {0, 0, 1};

// What certainty lacks goes to tents of probes with functions, over the square of light and a hundredth of its mean: by definition.
std::map<uint32_t, double> expectedShares(const LightGrid& grid, const ProbesAround& around) {
  ProbeWeights weights;
  weightsAround(grid, around, &weights);
  std::map<uint32_t, double> shares;
  double sum = 0.0, tents = 0.0, light = 0.0, darkest = 0.0;
  for (int k = 0; k < weights.count; ++k) sum += double{weights.weight[k]};
  for (int k = 0; k < weights.count; ++k) shares[weights.probe[k]] = double{weights.certainty} * weights.weight[k] / sum;
  const auto tentOf = [&](const ProbeAround& corner) {
    return grid.probe_function[corner.probe] == kNoWeight ? 0.0 : double{tent(corner.local)} * corner.tent_ratio;
  };
  const auto luminance = [&](uint32_t probe) {
    const float* mean = grid.probeLight(probe);
    return std::max(0.0, 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2]);
  };
  for (const ProbeAround& corner : around.corners) {
    tents += tentOf(corner);
    light += tentOf(corner) * luminance(corner.probe);
  }
  const auto weightOf = [&](const ProbeAround& corner) {
    return tentOf(corner) / std::pow(luminance(corner.probe) + 0.01 * light / tents, 2);
  };
  for (const ProbeAround& corner : around.corners) darkest += tents > 0.0 ? weightOf(corner) : 0.0;
  for (const ProbeAround& corner : around.corners) {
    if (tentOf(corner) > 0.0) shares[corner.probe] += (1.0 - double{weights.certainty}) * weightOf(corner) / darkest;
  }
  return shares;
}

TEST(Irradiance, IsTheBlendOfTheProbesLight) {
  int64_t of_status[4] = {}, at_floor = 0;
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
      ProbesAround around;
      ASSERT_TRUE(grid.tree.lookUp(at, &around));
      const std::map<uint32_t, double> shares = expectedShares(grid, around);
      ASSERT_EQ(status, shares.empty() ? LightStatus::unlit : weights.certainty < 1.0f ? LightStatus::faint : LightStatus::lit);
      double expected[3] = {}, floor[3] = {}, magnitude[3] = {};
      const std::array<float, kShCount> basis = shBasis(normal[0], normal[1], normal[2]);
      for (const auto& [probe, share] : shares) {
        for (int j = 0; j < kShFloats; ++j) {
          const double term = share * kCosineBand[j / 3] * basis[j / 3] * grid.probeLight(probe)[j];
          expected[j % 3] += term;
          if (j < 3) floor[j] += 0.1 * term;
          magnitude[j % 3] += std::abs(term);
        }
      }
      // shares: 9 roundings; products and sums of 8 probes: 9; of 9 coefficients: 11. Shares of the darkest: tents and ratios 12, sums
      // and mean 17, each in all shares alike but for the square of a quotient: 60
      const int roundings = status == LightStatus::faint ? 29 + 60 : 29;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(rgb[c], std::max(floor[c], expected[c]), roundings * kFloatRounding * magnitude[c])
            << lightStatusName(status);
        at_floor += expected[c] < floor[c];
      }
    }
  }
  EXPECT_GT(of_status[static_cast<int>(LightStatus::lit)], 1000);
  EXPECT_GT(of_status[static_cast<int>(LightStatus::faint)], 0);
  EXPECT_GT(of_status[static_cast<int>(LightStatus::unlit)], 0);
  EXPECT_GT(of_status[static_cast<int>(LightStatus::outside)], 100);
  EXPECT_GT(at_floor, 100);
}

TEST(Irradiance, OfDarkIsDark) {
  // a mean below 0, as noise leaves it, has no floor below 0
  std::array<float, kShFloats> light{};
  light[0] = -1e-3f;
  EXPECT_EQ(flooredIrradiance(light.data(), 0.0f, 0.0f, 1.0f), (std::array<float, 3>{}));
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

// All probes have this share of their tents, everywhere.
LightGrid gridOfShare(float share) {
  LightGrid grid = litGrid(smallTree(), 1);
  Theta theta(ThetaLayout::count);
  theta[ThetaLayout::b3] = share;
  std::fill(grid.probe_function.begin(), grid.probe_function.end(), grid.addFunction(1, theta.data()));
  return grid;
}

TEST(Irradiance, HoldsToTheDarkestProbesWhereNoWeightIsBelieved) {
  LightGrid grid = gridOfShare(0.5f * kResidue);
  Random random(1);
  int found = 0;
  for (int i = 0; i < 1000; ++i) {
    const PositionM at = randomPosition(grid.tree.frame(), random);
    ProbesAround around;
    if (!grid.tree.lookUp(at, &around)) continue;
    std::fill(grid.light.begin(), grid.light.end(), 0.0f);
    for (const ProbeAround& corner : around.corners) std::fill_n(&grid.light[corner.probe * kShFloats], kShChannels, 1.0f);
    const ProbeAround& dark = around.corners[random.below(8)];
    std::fill_n(&grid.light[dark.probe * kShFloats], kShChannels, 0.01f);
    float rgb[3];
    ASSERT_EQ(lookUpIrradiance(grid, at, kUp, rgb), LightStatus::faint);
    // with m <= 1 of mean light the dark one weighs more than 1 / .02^2 = 2500 times its tent, each other at most 1
    const double tent_of_dark = double{tent(dark.local)} * dark.tent_ratio;
    const double most = 0.01 + 0.99 * (1.0 - tent_of_dark) / (2500 * tent_of_dark);
    ASSERT_LE(rgb[0], 0.886226925 * most * (1 + 60 * kFloatRounding));
    ASSERT_GE(rgb[0], 0.886226925 * 0.01 * (1 - 60 * kFloatRounding));
    ++found;
  }
  EXPECT_GT(found, 100);
}

// From one residue to two certainty rises to 1: of light there is no step.
TEST(Irradiance, PassesFromTheDarkestToTheBlendWithoutAStep) {
  Random random(1);
  int found = 0;
  for (int i = 0; i < 40; ++i) {
    PositionM at{};
    double before = 0.0, largest = 0.0, first = 0.0;
    constexpr int kSteps = 256;
    for (int step = 0; step <= kSteps; ++step) {
      const LightGrid grid = gridOfShare(kResidue * (0.75f + 1.5f * static_cast<float>(step) / kSteps));
      if (step == 0) at = randomPosition(grid.tree.frame(), random);
      float rgb[3];
      if (lookUpIrradiance(grid, at, kUp, rgb) == LightStatus::outside) break;
      if (step == 0) first = double{rgb[0]};
      if (step > 0) largest = std::max(largest, std::abs(double{rgb[0]} - before));
      before = double{rgb[0]};
      found += step == kSteps;
    }
    // a step is 1.5 / 256 of the way; and weights below kLeastWeight, of sums of kResidue / 256, come in on it
    ASSERT_LE(largest, 1.6 / kSteps * std::abs(before - first) + 8 * 256 * double{kLeastWeight} / kResidue * 4);
  }
  EXPECT_GT(found, 10);
}

// Through faces between cells of one size, where four probes are exchanged for four others, one of them without light.
TEST(Irradiance, OfTheDarkestProbesHasNoStepBetweenCells) {
  LightGrid grid = gridOfShare(0.5f * kResidue);
  for (size_t probe = 0; probe < grid.tree.probeCount(); probe += 5) std::fill_n(&grid.light[probe * kShFloats], kShFloats, 0.0f);
  const ProbeTreeFrame& frame = grid.tree.frame();
  Random random(1);
  int found = 0;
  for (int i = 0; i < 4000; ++i) {
    const PositionM at = randomPosition(frame, random);
    ProbesAround around;
    if (!grid.tree.lookUp(at, &around)) continue;
    const size_t axis = random.below(3);
    const double face = around.cell.low[axis] + around.cell.side, apart = 0x1p-30 * around.cell.side;
    float rgb[2][3];
    ProbesAround beside[2];
    bool in_both = true;
    for (const size_t side : {0, 1}) {
      PositionM near = at;
      near[axis] = frame.first_m[axis] + frame.spacing_m * (face + (side == 0 ? -apart : apart));
      in_both = grid.tree.lookUp(near, &beside[side]) && in_both;
      lookUpIrradiance(grid, near, kUp, rgb[side]);
    }
    if (!in_both || beside[0].cell.low == beside[1].cell.low || beside[0].cell.side != beside[1].cell.side) continue;
    // the four have 2^-30 of a tent, with up to 10^4 times the say of others that have a tent of at least 10^-4 here
    bool is_clear = true;
    for (size_t other = 0; other < 3; ++other) {
      const double in_cell = (at[other] - frame.first_m[other]) / frame.spacing_m / around.cell.side;
      is_clear = is_clear && (other == axis || std::abs(in_cell - std::round(in_cell)) > 0.05);
    }
    if (!is_clear) continue;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb[0][c], rgb[1][c], 1e-4 * std::max(1.0f, rgb[0][c])) << i;
    ++found;
  }
  EXPECT_GT(found, 100);
}

TEST(Irradiance, IsNothingWhereNoProbeHasWeightOrTheGridNoLight) {
  LightGrid without_weight = litGrid(smallTree(), 1), without_light = randomGrid(smallTree(), 1);
  std::fill(without_weight.probe_function.begin(), without_weight.probe_function.end(), kNoWeight);
  Random random(1);
  int found = 0;
  for (int i = 0; i < 1000; ++i) {
    const PositionM at = randomPosition(without_weight.tree.frame(), random);
    for (const LightGrid* grid : {&without_weight, &without_light}) {
      float rgb[3] = {1, 1, 1};
      const LightStatus status = lookUpIrradiance(*grid, at, kUp, rgb);
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
  float border[3], rgb[3];
  ASSERT_NE(lookUpIrradiance(grid, at(0.0), kUp, border), LightStatus::outside);
  ASSERT_GT(border[0], 0.0f);
  for (const double x : {-0.001, -0.5, -0.999}) {
    EXPECT_EQ(lookUpIrradiance(grid, at(x), kUp, rgb), LightStatus::outside) << x;
    for (int c = 0; c < 3; ++c) EXPECT_EQ(rgb[c], border[c]) << x;
  }
  for (const double x : {-1.001, -1e300, 66.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_EQ(lookUpIrradiance(grid, at(x), kUp, rgb), LightStatus::outside) << x;
    EXPECT_EQ(rgb[0] + rgb[1] + rgb[2], 0.0f) << x;
  }
  EXPECT_EQ(lookUpIrradiance(LightGrid{}, {0, 0, 0}, kUp, rgb), LightStatus::outside);
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
