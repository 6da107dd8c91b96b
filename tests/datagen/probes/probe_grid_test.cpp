#include "datagen/probes/probe_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/datagen/hand_built_scenes.h"
#include "tool/error.h"

namespace nlg {
namespace {

Scene boxScene(const glm::vec3& low, const glm::vec3& high) {
  SceneOfFaces faces;
  faces.addBox(low, high);
  return faces.finish();
}

TEST(ProbeGrid, CoversTheBoundsToWithinOneSpacing) {
  const glm::vec3 low(-3, 1, 10), high(9, 5, 31);
  const Scene scene = boxScene(low, high);
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const ProbeGrid grid = makeProbeGrid(scene, {}, seed);
    ASSERT_TRUE(grid.spacing_m >= 0.7f && grid.spacing_m <= 2.2f) << "seed " << seed << ": " << grid.spacing_m;
    for (int axis = 0; axis < 3; ++axis) {
      const double first = grid.first_m[axis], last = grid.probePosition(grid.probeCount() - 1)[axis];
      ASSERT_TRUE(first >= low[axis] && first < low[axis] + grid.spacing_m) << "seed " << seed << ", axis " << axis;
      ASSERT_TRUE(last <= high[axis] && last > high[axis] - grid.spacing_m) << "seed " << seed << ", axis " << axis;
    }
  }
}

TEST(ProbeGrid, HasProbesOnBothSidesOfASceneThinnerThanASpacing) {
  const glm::vec3 low(0, 2, 0), high(10, 2.01f, 10);
  const Scene scene = boxScene(low, high);
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const ProbeGrid grid = makeProbeGrid(scene, {}, seed);
    ASSERT_GE(grid.extent.y, 2) << "seed " << seed;
    ASSERT_LT(grid.first_m.y, low.y + 0.011) << "seed " << seed;
    ASSERT_GT(grid.probePosition(grid.probeCount() - 1).y, low.y) << "seed " << seed;
  }
}

TEST(ProbeGrid, CountsXFastest) {
  ProbeGrid grid;
  grid.spacing_m = 0.5f;
  grid.first_m = {10, 20, 30};
  grid.extent = {2, 3, 4};
  EXPECT_EQ(grid.probeCount(), 24u);
  EXPECT_EQ(grid.probePosition(0), glm::dvec3(10, 20, 30));
  EXPECT_EQ(grid.probePosition(1), glm::dvec3(10.5, 20, 30));
  EXPECT_EQ(grid.probePosition(2), glm::dvec3(10, 20.5, 30));
  EXPECT_EQ(grid.probePosition(6), glm::dvec3(10, 20, 30.5));
  EXPECT_EQ(grid.probePosition(23), glm::dvec3(10.5, 21, 31.5));
}

TEST(ProbeGrid, IsAPureFunctionOfItsSeed) {
  const Scene scene = boxScene({0, 0, 0}, {10, 10, 10});
  std::set<float> spacings;
  std::set<double> shifts;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const ProbeGrid a = makeProbeGrid(scene, {}, seed), b = makeProbeGrid(scene, {}, seed);
    EXPECT_EQ(a.spacing_m, b.spacing_m);
    EXPECT_EQ(a.first_m, b.first_m);
    spacings.insert(a.spacing_m);
    shifts.insert(a.first_m.x);
  }
  EXPECT_EQ(spacings.size(), 20u);
  EXPECT_EQ(shifts.size(), 20u);
}

TEST(ProbeGrid, DrawsItsSpacingEvenlyInTheLogarithm) {
  // half of the draws lie below the geometric mean; 400 of them deviate by 10 a standard deviation
  const Scene scene = boxScene({0, 0, 0}, {10, 10, 10});
  int below = 0;
  for (uint64_t seed = 0; seed < 400; ++seed) below += makeProbeGrid(scene, {0.5, 8.0}, seed).spacing_m < 2.0f;
  EXPECT_NEAR(below, 200, 4 * 10);
}

TEST(ProbeGrid, TakesOneSpacingForBothLimits) {
  EXPECT_EQ(makeProbeGrid(boxScene({0, 0, 0}, {9, 9, 9}), {1.5, 1.5}, 3).spacing_m, 1.5f);
}

TEST(ProbeGrid, OfAnEmptySceneIsEmpty) {
  const ProbeGrid grid = makeProbeGrid(Scene{}, {}, 1);
  EXPECT_EQ(grid.probeCount(), 0u);
}

TEST(ProbeGrid, RefusesMoreProbesThanCanBeCounted) {
  EXPECT_THROW(makeProbeGrid(boxScene({-1e5f, -1e5f, -1e5f}, {1e5f, 1e5f, 1e5f}), {0.001, 0.001}, 1), UsageError);
  EXPECT_THROW(makeProbeGrid(boxScene({-1e30f, 0, 0}, {1e30f, 1, 1}), {}, 1), UsageError);
}

TEST(ShuffledOrder, VisitsEverythingOnce) {
  for (const uint64_t count : {0u, 1u, 2u, 3u, 7u, 8u, 9u, 1000u, 1024u, 1025u, 65537u}) {
    ShuffledOrder order(count, 5);
    std::vector<bool> visited(count, false);
    uint64_t index = 0, visits = 0;
    for (; order.next(&index); ++visits) {
      ASSERT_LT(index, count);
      ASSERT_FALSE(visited[index]) << index << " twice of " << count;
      visited[index] = true;
    }
    EXPECT_EQ(visits, count);
    EXPECT_FALSE(order.next(&index)) << "after the end of " << count;
  }
}

TEST(ShuffledOrder, DependsOnItsSeedAlone) {
  const auto prefix = [](uint64_t seed) {
    ShuffledOrder order(100000, seed);
    std::vector<uint64_t> indices(50);
    for (uint64_t& index : indices) order.next(&index);
    return indices;
  };
  EXPECT_EQ(prefix(1), prefix(1));
  EXPECT_NE(prefix(1), prefix(2));
}

TEST(ShuffledOrder, StartsWithAFairSample) {
  // the mean of the first 1000 of 10^6 indices: deviation 10^6 / sqrt(12 * 1000) when they are drawn independently
  for (uint64_t seed = 0; seed < 20; ++seed) {
    ShuffledOrder order(1000000, seed);
    double sum = 0.0;
    uint64_t index = 0;
    for (int i = 0; i < 1000; ++i) order.next(&index), sum += static_cast<double>(index);
    EXPECT_NEAR(sum / 1000, 5e5, 5 * 9130) << "seed " << seed;
  }
}

}  // namespace
}  // namespace nlg
