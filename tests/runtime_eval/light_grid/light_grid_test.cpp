
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "nlg/look_up.h"
#include "tests/runtime_eval/light_grid/look_up_bounds.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

constexpr uint64_t kGridCount = 6;

struct Expected {
  double weight = 0.0, above = 0.0, bound = 0.0;  // above: what v has above the residue; bound: what float may lose of the weight
};

// Of one corner, by the header's words in double.
Expected expectedWeight(const LightGrid& grid, const ProbeAround& corner) {
  const uint32_t function = grid.probe_function[corner.probe];
  if (function == kNoWeight) return {};
  const double bare = double{tent(corner.local)}, residue = double{kResidue};
  // 3 roundings of the tent, one each of the share, what it loses, what that is divided by, the quotient and two products
  double v = 1.0, bound = 9 * kFloatRounding;
  if (function != kFreeSpace) {
    const Representation& representation = grid.representations[grid.function_representation[function]];
    const Theta theta = thetaOf(grid, function);
    const double phi = evaluateReference(representation, corner.local, toDouble(theta).data());
    v = phi <= 0.0 ? 0.0 : phi < bare ? phi / bare : 1.0;
    // clamping moves two values no further apart
    bound += errorBound(representation, corner.local, theta);
  }
  const double above = std::max(0.0, v - residue);
  return {bare * corner.tent_ratio * above / (1.0 - residue), above, bound * corner.tent_ratio / (1.0 - residue)};
}

float weightOf(const ProbeWeights& weights, uint32_t probe) {
  for (int i = 0; i < weights.count; ++i)
    if (weights.probe[i] == probe) return weights.weight[i];
  return 0.0f;
}

// Calls check with positions in and around grids with level borders of every kind, after prepare has changed them.
template <class Prepare, class Check>
void forManyPositions(const Prepare& prepare, const Check& check) {
  for (uint64_t seed = 0; seed < kGridCount; ++seed) {
    RandomTree random_tree = randomTree(seed);
    SCOPED_TRACE(random_tree.name);
    LightGrid grid = randomGrid(std::move(random_tree.tree), seed);
    prepare(grid);
    ASSERT_TRUE(checkLightGrid(grid).ok()) << checkLightGrid(grid).detail;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
      check(grid, randomPosition(grid.tree.frame(), random));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(LightGrid, LooksUpTheWeightsOfItsDefinition) {
  int64_t found = 0, counted = 0, faint = 0;
  // in a part of the grid a function that is hardly more than the residue
  const auto makeFaint = [](LightGrid& grid) {
    std::fill_n(&grid.theta[grid.theta_begin[1]], ThetaLayout::count, 0.0f);
    grid.theta[grid.theta_begin[1] + ThetaLayout::b3] = 1.5f * kResidue;
    std::fill_n(grid.probe_function.begin(), grid.probe_function.size() / 4, 1u);
  };
  forManyPositions(makeFaint, [&](const LightGrid& grid, const PositionM& position_m) {
    ProbesAround around;
    ProbeWeights weights;
    const bool inside = lookUpWeights(grid, position_m, &weights);
    ASSERT_EQ(inside, grid.tree.lookUp(position_m, &around));
    if (!inside) return;
    ++found;
    int next = 0;
    double sum = 0.0, believed = 0.0, bound = 0.0;
    for (const ProbeAround& corner : around.corners) {
      const Expected expected = expectedWeight(grid, corner);
      // what is too small to count is left out
      const double left_out = expected.weight - expected.bound < kLeastWeight ? kLeastWeight : 0.0;
      ASSERT_NEAR(weightOf(weights, corner.probe), expected.weight, expected.bound + left_out) << "probe " << corner.probe;
      if (next < weights.count && weights.probe[next] == corner.probe) ++next;
      sum += expected.weight;
      believed += expected.weight * expected.above;
      bound += expected.bound + left_out;
    }
    // a weight is off by its bound, and what its v is off by, times the weight, is no more: thrice, numerator and sum
    if (sum > bound) {
      ASSERT_NEAR(weights.certainty, std::min(1.0, believed / (kResidue * sum)), 3 * bound / (kResidue * sum));
      faint += weights.certainty < 1.0f;
    }
    ASSERT_EQ(next, weights.count) << "every probe is a corner, in the order of corners";
    for (int i = 0; i < weights.count; ++i) ASSERT_TRUE(weights.weight[i] >= kLeastWeight && weights.weight[i] <= 1.0f);
    counted += weights.count;
  });
  EXPECT_GT(found, 1000);
  EXPECT_GT(counted, found);
  EXPECT_GT(faint, 0);
}

TEST(LightGrid, AddsUpToOneInFreeSpace) {
  int64_t found = 0;
  const auto allFree = [](LightGrid& grid) { std::fill(grid.probe_function.begin(), grid.probe_function.end(), kFreeSpace); };
  forManyPositions(allFree, [&](const LightGrid& grid, const PositionM& position_m) {
    ProbeWeights weights;
    if (!lookUpWeights(grid, position_m, &weights)) return;
    double sum = 0.0;
    for (int i = 0; i < weights.count; ++i) sum += double{weights.weight[i]};
    // per weight 3 factors of at most 4 roundings, their products, and weights that add up to 1
    ASSERT_NEAR(sum, 1.0, 20 * kFloatRounding);
    ++found;
  });
  EXPECT_GT(found, 1000);
}

// A grid whose probes all have one function: the same share of the tent everywhere.
LightGrid constantGrid(float share) {
  LightGrid grid = randomGrid(smallTree(), 1);
  Theta theta(ThetaLayout::count);
  theta[ThetaLayout::b3] = share;
  const uint32_t function = grid.addFunction(1, theta.data());  // tent_mlp
  std::fill(grid.probe_function.begin(), grid.probe_function.end(), function);
  return grid;
}

// The largest change of any share from one of `steps` + 1 places on a line inside one cell to the next.
double largestStep(const LightGrid& grid, const PositionM& from, const PositionM& to, int steps) {
  std::map<uint32_t, double> before;
  double largest = 0.0;
  for (int i = 0; i <= steps; ++i) {
    PositionM at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = from[axis] + (to[axis] - from[axis]) * i / steps;
    ProbeWeights weights;
    lookUpWeights(grid, at, &weights);
    normaliseWeights(&weights);
    std::map<uint32_t, double> now;
    for (int k = 0; k < weights.count; ++k) now[weights.probe[k]] = weights.weight[k];
    if (i > 0) {
      for (const auto& [probe, share] : now) largest = std::max(largest, std::abs(share - before[probe]));
      for (const auto& [probe, share] : before) largest = std::max(largest, std::abs(share - now[probe]));
    }
    before = std::move(now);
  }
  return largest;
}

TEST(LightGrid, TakesTheResidueOffWithoutAJump) {
  // shares that run through 0 to 6 residues, so that along a line some reach the residue, and all are less than twice of it
  LightGrid grid = constantGrid(0.0f);
  std::vector<uint32_t> functions;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Random random(seed);
    Theta theta(ThetaLayout::count);
    // one unit of each layer: bias + slope along x, y and z
    for (int axis = 0; axis < 3; ++axis) theta[ThetaLayout::w1 + axis] = static_cast<float>(random.uniform(-6.0, 6.0)) * kResidue;
    theta[ThetaLayout::b1] = static_cast<float>(random.uniform(0.0, 3.0)) * kResidue;
    theta[ThetaLayout::w2] = theta[ThetaLayout::w3] = 1.0f;
    functions.push_back(grid.addFunction(1, theta.data()));
  }
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) grid.probe_function[probe] = functions[probe % 8];
  int lines = 0, fades = 0;
  std::vector<ProbeCell> cells;
  grid.tree.forEachCell([&](const ProbeCell& cell) { cells.push_back(cell); });
  for (size_t i = 0; i < cells.size(); i += 7) {
    const auto at = [&](double x, double y, double z) {
      const ProbeCell& cell = cells[i];
      return positionAt(grid.tree.frame(),
                        {cell.low[0] + cell.side * x, cell.low[1] + cell.side * y, cell.low[2] + cell.side * z});
    };
    const double coarse = largestStep(grid, at(0.2, 0.3, 0.3), at(0.8, 0.6, 0.7), 2000),
                 fine = largestStep(grid, at(0.2, 0.3, 0.3), at(0.8, 0.6, 0.7), 32000);
    // a slope shrinks with the step, a jump does not. Where the last weight fades out the certainty is at most its v over the residue,
    // and a weight below kLeastWeight under a tent of .008 and more has no more than kLeastWeight / .008 of that
    ASSERT_LE(fine, coarse / 8 + kLeastWeight / 0.008 / kResidue) << "cell " << i;
    ++lines;
    fades += coarse > 0.0;
  }
  EXPECT_GT(lines, 20);
  EXPECT_GT(fades, 10);
}

TEST(LightGrid, FadesOutWhereAPositionLeavesAProbesCells) {
  // a probe that is not on a face has at most its share of the cell's side as weight, whatever its function says: what the look-up
  // beyond the face no longer reads was 0 there
  int64_t near_a_face = 0;
  forManyPositions([](LightGrid&) {},
                   [&](const LightGrid& grid, const PositionM& position_m) {
                     ProbesAround around;
                     ProbeWeights weights;
                     if (!lookUpWeights(grid, position_m, &weights)) return;
                     ASSERT_TRUE(grid.tree.lookUp(position_m, &around));
                     for (int c = 0; c < 8; ++c) {
                       for (int axis = 0; axis < 3; ++axis) {
                         const double low = grid.tree.frame().first_m[axis] + grid.tree.frame().spacing_m * around.cell.low[axis],
                                      side = grid.tree.frame().spacing_m * around.cell.side;
                         const double from_low = (position_m[axis] - low) / side;
                         const double to_far_face = c >> axis & 1 ? from_low : 1.0 - from_low;
                         // up to 6 roundings of numbers up to 1
                         ASSERT_LE(weightOf(weights, around.corners[c].probe), to_far_face + 6 * kFloatRounding)
                             << "corner " << c << ", axis " << axis;
                         near_a_face += to_far_face < 0.05;
                       }
                     }
                   });
  EXPECT_GT(near_a_face, 1000);
}

TEST(LightGrid, NormalisesToTheCertaintyAndKeepsRatios) {
  int64_t normalised = 0;
  forManyPositions([](LightGrid&) {},
                   [&](const LightGrid& grid, const PositionM& position_m) {
                     ProbeWeights weights;
                     if (!lookUpWeights(grid, position_m, &weights)) return;
                     const ProbeWeights before = weights;
                     ASSERT_EQ(normaliseWeights(&weights), before.count > 0);
                     ASSERT_EQ(weights.count, before.count);
                     double sum = 0.0;
                     for (int i = 0; i < weights.count; ++i) {
                       sum += double{weights.weight[i]};
                       ASSERT_EQ(weights.probe[i], before.probe[i]);
                       // one rounding of each product
                       ASSERT_NEAR(weights.weight[i] * before.weight[0], weights.weight[0] * before.weight[i],
                                   4 * kFloatRounding);
                     }
                     if (weights.count == 0) return;
                     // 7 roundings of the sum, one of the quotient, one of each of 8 products that add up to 1
                     ASSERT_NEAR(sum, weights.certainty, 10 * kFloatRounding);
                     ++normalised;
                   });
  EXPECT_GT(normalised, 1000);
}

}  // namespace
}  // namespace nlg
