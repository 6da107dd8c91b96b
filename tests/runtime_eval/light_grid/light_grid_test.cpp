
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <latch>
#include <limits>
#include <map>
#include <numeric>
#include <thread>

#include "nlg/look_up.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "tests/runtime_eval/counting_new.h"
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

bool sameWeights(const ProbeWeights& a, const ProbeWeights& b) {
  return a.count == b.count && std::equal(a.probe, a.probe + a.count, b.probe) &&
         std::equal(a.weight, a.weight + a.count, b.weight);
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

TEST(EvaluatePoint, EqualsTheReference) {
  for (const Representation& representation : kGridRepresentations) {
    for (uint64_t seed = 0; seed < 20; ++seed) {
      const Theta theta = randomGridTheta(representation, seed);
      std::vector<LocalPoint> points = testPoints(50);
      for (const float x : {-1.0f, 0.0f, 1.0f}) points.push_back({x, -x, 1.0f});
      for (const LocalPoint& point : points) {
        ASSERT_NEAR(evaluatePoint(representation, point, theta.data()),
                    evaluateReference(representation, point, toDouble(theta).data()), errorBound(representation, point, theta))
            << representationName(representation) << ", seed " << seed << " at " << point[0] << ", " << point[1] << ", "
            << point[2];
      }
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

TEST(LightGrid, GivesTentsToProbesThatHaveAnyWeight) {
  int64_t found = 0;
  forManyPositions([](LightGrid&) {},
                   [&](const LightGrid& grid, const PositionM& position_m) {
                     ProbesAround around;
                     ProbeWeights weights;
                     weights.count = 5;
                     ASSERT_EQ(lookUpTents(grid, position_m, &weights), grid.tree.lookUp(position_m, &around));
                     if (!grid.tree.lookUp(position_m, &around)) {
                       ASSERT_EQ(weights.count, 5);
                       return;
                     }
                     for (const ProbeAround& corner : around.corners) {
                       const float expected = tent(corner.local) * corner.tent_ratio;
                       const bool counts = grid.probe_function[corner.probe] != kNoWeight && expected >= kLeastWeight;
                       ASSERT_EQ(weightOf(weights, corner.probe), counts ? expected : 0.0f);
                       found += counts;
                     }
                   });
  EXPECT_GT(found, 1000);
}

TEST(LightGrid, FindsNothingOutside) {
  const LightGrid grid = randomGrid(smallTree(), 1);
  ProbeWeights weights;
  weights.count = 5;
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const PositionM first = grid.tree.frame().first_m;
  for (const double x : {first[0] - 1.0, first[0] + 33.0, nan, infinity, -infinity, 1e300}) {
    EXPECT_FALSE(lookUpWeights(grid, {x, first[1] + 1.0, first[2] + 1.0}, &weights)) << x;
    EXPECT_EQ(weights.count, 5) << x;
  }
  EXPECT_FALSE(lookUpWeights(LightGrid{}, {0, 0, 0}, &weights));
}

TEST(LightGrid, StaysInRangeUpToTheLargestTheta) {
  LightGrid grid = randomGrid(smallTree(), 1);
  for (float& value : grid.theta) value = value < 0 ? -kMaxGridTheta : kMaxGridTheta;
  for (size_t function = 0; function < 2; ++function)
    std::fill_n(grid.theta.begin() + static_cast<int64_t>(grid.theta_begin[function]), ThetaLayout::count, kMaxGridTheta);
  grid.makeBricks();
  ASSERT_TRUE(checkLightGrid(grid).ok());
  Random random(2);
  float largest = 0.0f;
  for (int i = 0; i < 4000; ++i) {
    ProbeWeights weights;
    if (!lookUpWeights(grid, randomPosition(grid.tree.frame(), random), &weights)) continue;
    for (int k = 0; k < weights.count; ++k) {
      ASSERT_TRUE(weights.weight[k] >= kLeastWeight && weights.weight[k] <= 1.0f) << "probe " << weights.probe[k];
      largest = std::max(largest, weights.weight[k]);
    }
  }
  EXPECT_GT(largest, 0.5f);
}

TEST(LightGrid, HoldsTheBrickOfEveryCode) {
  const LightGrid grid = randomGrid(smallTree(), 1);
  size_t quads = 0;
  int codes = 0;
  for (size_t f = 0; f < grid.functionCount(); ++f) {
    const Representation& representation = grid.representations[grid.function_representation[f]];
    if (!representation.isCode()) {
      EXPECT_EQ(grid.function_brick[f].step, 0.0f);
      continue;
    }
    ++codes;
    const int r = representation.resolution;
    int8_t brick[kMaxBrickNodes];
    const float step = packBrick(*representation.dictionary, grid.functionTheta(f), brick);
    EXPECT_EQ(grid.function_brick[f].step, step);
    EXPECT_EQ(grid.function_brick[f].begin, quads);
    quads += quadCount(r);
    for (const LocalPoint& point : testPoints(200)) {
      // the same operations on the same numbers, fused or not
      EXPECT_NEAR(evaluateQuads(r, point, step, grid.functionQuads(f)), evaluateBrick(r, point, step, brick),
                  8 * kFloatRounding * kMostLogitSteps * step);
    }
  }
  EXPECT_EQ(codes, 4);
  EXPECT_EQ(grid.quads.size(), quads);
}

TEST(LightGrid, MakesBricksAnewAsTheyWereMade) {
  const LightGrid grid = randomGrid(smallTree(), 2);
  LightGrid other = grid;
  for (float& value : other.theta) value += 1.0f;
  other.makeBricks();
  EXPECT_NE(other.quads, grid.quads);
  other.theta = grid.theta;
  other.makeBricks();
  EXPECT_EQ(other.quads, grid.quads);
}

TEST(LightGrid, TakesCodesThatItsCheckRefuses) {
  LightGrid grid = randomGrid(smallTree(), 3);
  Theta broken(64, 0.0f);
  for (const float value : {std::nanf(""), HUGE_VALF, 2e9f}) {
    broken[5] = value;
    LightGrid other = grid;
    other.addFunction(6, broken.data());
    EXPECT_EQ(other.quads, grid.quads);
    EXPECT_FALSE(checkLightGrid(other).ok());
  }
  // a representation of which only the name is known
  Representation named;
  ASSERT_TRUE(findRepresentation("code64", &named));
  grid.representations.push_back(named);
  grid.addFunction(8, broken.data());
  EXPECT_NE(checkLightGrid(grid).detail.find("dictionary"), std::string::npos);
}

TEST(LightGrid, AllocatesNothingInALookUp) {
  const LightGrid grid = randomGrid(smallTree(), 3);
  Random random(3);
  int found = 0;
  const long before = allocationCount();
  for (int i = 0; i < 1000; ++i) {
    ProbeWeights weights;
    found += lookUpWeights(grid, randomPosition(grid.tree.frame(), random), &weights);
  }
  EXPECT_EQ(allocationCount(), before);
  EXPECT_GT(found, 100);
}

// What a look-up kept between calls, of a cell, a function or a result, would be another grid's or another thread's here: all
// look-ups go through the same places in other orders.
struct ManyLookUps {
  LightGrid grids[2] = {randomGrid(smallTree(), 4), randomGrid(smallTree(), 5)};
  std::vector<PositionM> positions;
  std::vector<ProbeWeights> alone[2];  // by grid and position, one after another

  ManyLookUps() {
    Random random(4);
    for (int i = 0; i < 20000; ++i) positions.push_back(randomPosition(grids[0].tree.frame(), random));
    for (int grid = 0; grid < 2; ++grid) {
      for (const PositionM& position_m : positions) lookUpWeights(grids[grid], position_m, &alone[grid].emplace_back());
    }
  }
  bool isSame(int grid, size_t i) const {
    ProbeWeights weights;
    lookUpWeights(grids[grid], positions[i], &weights);
    return sameWeights(weights, alone[grid][i]);
  }
};

TEST(LightGrid, GivesTheSameToTwoThreadsAtOnce) {
  const ManyLookUps many;
  constexpr int kRounds = 5;  // long enough for the threads to meet, also where they share one core
  std::latch start(2);
  // the places that differ; one thread takes the positions forwards in one grid, the other backwards in the other grid
  const auto wrong = [&](int grid) {
    int count = 0;
    start.arrive_and_wait();
    for (int round = 0; round < kRounds; ++round) {
      for (size_t i = 0; i < many.positions.size(); ++i) {
        count += !many.isSame((grid + round) % 2, grid == 0 ? i : many.positions.size() - 1 - i);
      }
    }
    return count;
  };
  int other = -1;
  std::thread thread([&] { other = wrong(1); });
  EXPECT_EQ(wrong(0), 0);
  thread.join();
  EXPECT_EQ(other, 0);
}

// A good grid with one thing wrong, and what the check says to it.
struct WrongGrid {
  const char* what;
  FileStatus status;
  void (*spoil)(LightGrid&);
};

TEST(LightGridCheck, NamesWhatDoesNotBelongTogether) {
  const WrongGrid cases[] = {
      {"a probe too few", FileStatus::tensor_unexpected, [](LightGrid& g) { g.probe_function.pop_back(); }},
      {"no such function", FileStatus::value_out_of_range, [](LightGrid& g) { g.probe_function[7] = 16; }},
      {"just below kNoWeight", FileStatus::value_out_of_range, [](LightGrid& g) { g.probe_function[7] = kNoWeight - 1; }},
      {"no such representation", FileStatus::value_out_of_range, [](LightGrid& g) { g.function_representation[3] = 8; }},
      {"another representation", FileStatus::value_out_of_range, [](LightGrid& g) { g.function_representation[3] = 4; }},
      {"a function too few", FileStatus::tensor_unexpected, [](LightGrid& g) { g.function_representation.pop_back(); }},
      {"theta too short", FileStatus::tensor_unexpected, [](LightGrid& g) { g.theta.pop_back(); }},
      {"theta too long", FileStatus::tensor_unexpected, [](LightGrid& g) { g.theta.push_back(0.0f); }},
      {"theta_begin shifted", FileStatus::value_out_of_range, [](LightGrid& g) { ++g.theta_begin[2]; }},
      {"theta_begin's end", FileStatus::value_out_of_range, [](LightGrid& g) { g.theta_begin.back() = 1u << 30; }},
      {"no theta_begin", FileStatus::tensor_unexpected, [](LightGrid& g) { g.theta_begin.clear(); }},
      {"NaN", FileStatus::value_not_finite, [](LightGrid& g) { g.theta[5] = std::numeric_limits<float>::quiet_NaN(); }},
      {"infinity", FileStatus::value_not_finite, [](LightGrid& g) { g.theta[5] = std::numeric_limits<float>::infinity(); }},
      {"too large", FileStatus::value_out_of_range, [](LightGrid& g) { g.theta[5] = -1.0001e9f; }},
      {"light of a probe too few", FileStatus::tensor_unexpected, [](LightGrid& g) { g.light.pop_back(); }},
      {"light NaN", FileStatus::value_not_finite, [](LightGrid& g) { g.light[5] = std::numeric_limits<float>::quiet_NaN(); }},
      {"light too bright", FileStatus::value_out_of_range, [](LightGrid& g) { g.light[5] = 1.1e9f; }},
      {"slope 1", FileStatus::value_out_of_range, [](LightGrid& g) { g.representations[0].slope = 1.0f; }},
      {"slope NaN", FileStatus::value_out_of_range, [](LightGrid& g) { g.representations[1].slope = std::nanf(""); }},
      {"pf4", FileStatus::value_out_of_range, [](LightGrid& g) { g.representations[3].resolution = 4; }},
      {"code40", FileStatus::value_out_of_range, [](LightGrid& g) { g.representations[6].code_count = 40; }},
      {"no dictionary", FileStatus::value_out_of_range, [](LightGrid& g) { g.representations[6].dictionary = nullptr; }},
      {"a dictionary that does not fit its codes", FileStatus::value_out_of_range,
       [](LightGrid& g) { g.representations[6].dictionary = g.representations[7].dictionary; }},
      {"bricks of another resolution", FileStatus::value_out_of_range,
       [](LightGrid& g) { g.representations[6].dictionary = sampleDictionary(7, 64, 1), g.representations[6].resolution = 7; }},
      {"a brick too few", FileStatus::tensor_unexpected, [](LightGrid& g) { g.function_brick.pop_back(); }},
      {"a brick where none is", FileStatus::value_out_of_range, [](LightGrid& g) { g.function_brick[6].begin += 1; }},
      {"a brick without a step", FileStatus::value_out_of_range, [](LightGrid& g) { g.function_brick[7].step = 0.0f; }},
      {"half a brick", FileStatus::tensor_unexpected, [](LightGrid& g) { g.quads.pop_back(); }},
      {"no bricks", FileStatus::tensor_unexpected, [](LightGrid& g) { g.function_brick.clear(), g.quads.clear(); }},
      {"many representations", FileStatus::value_out_of_range, [](LightGrid& g) { g.representations.resize(257); }},
  };
  ASSERT_TRUE(checkLightGrid(LightGrid{}).ok());
  for (const WrongGrid& wrong : cases) {
    LightGrid grid = litGrid(smallTree(), 1);
    ASSERT_TRUE(checkLightGrid(grid).ok());
    wrong.spoil(grid);
    const FileResult result = checkLightGrid(grid);
    EXPECT_EQ(result.status, wrong.status) << wrong.what << ": " << fileStatusName(result.status);
    EXPECT_FALSE(result.detail.empty()) << wrong.what;
    EXPECT_EQ(result.detail.find('\n'), std::string::npos) << result.detail;
  }
}

}  // namespace
}  // namespace nlg
