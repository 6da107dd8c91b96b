#include "datagen/probes/probe_placement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "datagen/probes/nearby_triangles.h"
#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/input_error.h"
#include "tool/error.h"

namespace nlg {
namespace {

Scene boxScene(const glm::vec3& low, const glm::vec3& high) { return SceneOfFaces().addBox(low, high).finish(); }

// Triangles of all sizes in a box of 20 m, every seventh of them a needle.
Scene randomScene(uint64_t seed, int triangle_count) {
  Random random(mixSeed(seed, 0x7363656e65));
  const auto coordinate = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
  const auto point = [&](double size) {
    const float x = coordinate(size), y = coordinate(size), z = coordinate(size);
    return glm::vec3(x, y, z);
  };
  SceneOfFaces faces;
  for (int i = 0; i < triangle_count; ++i) {
    const double size = std::exp(random.uniform(-4.0, 2.0));
    const glm::vec3 a = point(10.0), b = a + point(size);
    faces.addTriangle(a, b, i % 7 == 0 ? b + point(1e-3) : a + point(size));
  }
  return faces.finish();
}

PositionM positionOf(const glm::dvec3& p) { return {p.x, p.y, p.z}; }
glm::dvec3 randomIn(const glm::dvec3& low, const glm::dvec3& high, Random& random) {
  const double x = random.uniform(low.x, high.x), y = random.uniform(low.y, high.y), z = random.uniform(low.z, high.z);
  return {x, y, z};
}

glm::dvec3 lowCorner(const ProbeTree& tree, const ProbeCell& cell) {
  const auto& [x, y, z] = tree.frame().first_m;
  return glm::dvec3(x, y, z) + tree.frame().spacing_m * glm::dvec3(cell.low[0], cell.low[1], cell.low[2]);
}

// The nearest of many points of every triangle: never below the distance.
double sampledDistance(const Scene& scene, const glm::dvec3& low, const glm::dvec3& high) {
  constexpr int kSteps = 12;
  double nearest = HUGE_VAL;
  for (const glm::uvec3& t : scene.triangles) {
    const glm::dvec3 a = scene.positions[t.x], b = scene.positions[t.y], c = scene.positions[t.z];
    for (int u = 0; u <= kSteps; ++u) {
      for (int v = 0; u + v <= kSteps; ++v) {
        const glm::dvec3 p = a + (b - a) * (u / double(kSteps)) + (c - a) * (v / double(kSteps));
        nearest = std::min(nearest, glm::length(p - glm::clamp(p, low, high)));
      }
    }
  }
  return nearest;
}

TEST(NearbyTriangles, AnswersAsEveryTriangleByItself) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene = randomScene(seed, 100);
    const NearbyTriangles nearby(scene);
    std::vector<Scene> singles;
    for (size_t t = 0; t < scene.triangles.size(); ++t) {
      singles.push_back(scene);
      singles.back().triangles = {scene.triangles[t]};
    }
    Random random(seed);
    for (int i = 0; i < 100; ++i) {
      const glm::dvec3 low = randomIn(glm::dvec3(-15), glm::dvec3(15), random);
      const glm::dvec3 high = low + randomIn(glm::dvec3(0), glm::dvec3(4), random);
      const double distance = std::exp(random.uniform(-4.0, 2.0));
      const bool any = std::any_of(singles.begin(), singles.end(),
                                   [&](const Scene& single) { return NearbyTriangles(single).anyCloser(low, high, distance); });
      ASSERT_EQ(nearby.anyCloser(low, high, distance), any) << "seed " << seed << ", box " << i << ", distance " << distance;
    }
  }
}

TEST(ProbePlacement, EveryPositionOfTheBoundsHasProbes) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const Scene scene = randomScene(seed, 30);
    const Bounds bounds = sceneBounds(scene);
    ProbePlacementOptions options;
    options.density_growth = 0.25 * static_cast<double>(seed % 4);
    const ProbeTree tree = placeProbes(scene, options, seed);
    Random random(seed);
    ProbesAround around;
    for (int i = 0; i < 5000; ++i) {
      glm::dvec3 p = randomIn(bounds.min, bounds.max, random);
      // on the faces too, exactly
      for (int axis = 0; axis < 3; ++axis) {
        if (random.chance(0.1)) p[axis] = random.chance(0.5) ? bounds.min[axis] : bounds.max[axis];
      }
      ASSERT_TRUE(tree.lookUp(positionOf(p), &around)) << "seed " << seed << ": " << p.x << ", " << p.y << ", " << p.z;
    }
  }
}

TEST(ProbePlacement, CellsAreAsFineAsTheirDistanceFromGeometryAsks) {
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const Scene scene = randomScene(seed, 5);
    ProbePlacementOptions options;
    options.density_growth = 0.5 + 0.5 * static_cast<double>(seed % 2);
    options.extent = ExtentBox{glm::dvec3(-60), glm::dvec3(60)};
    const ProbeTree tree = placeProbes(scene, options, seed);
    std::set<int32_t> sides;
    tree.forEachCell([&](const ProbeCell& cell) {
      sides.insert(cell.side);
      if (cell.side == 1) return;
      const double side_m = tree.frame().spacing_m * cell.side;
      const glm::dvec3 low = lowCorner(tree, cell);
      EXPECT_LE(side_m, options.density_growth * sampledDistance(scene, low, low + side_m) * (1 + 1e-9))
          << "seed " << seed << ", cell of side " << cell.side << " at " << low.x << ", " << low.y << ", " << low.z;
    });
    EXPECT_GE(sides.size(), 4u) << "seed " << seed;
  }
}

TEST(ProbePlacement, SlowGrowthKeepsGeometryOutOfCoarseSupports) {
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const Scene scene = randomScene(seed, 5);
    ProbePlacementOptions options;
    options.density_growth = 0.57;  // < 1 / sqrt(3)
    options.extent = ExtentBox{glm::dvec3(-40), glm::dvec3(40)};
    const ProbeTree tree = placeProbes(scene, options, seed);
    const auto finest = static_cast<float>(tree.frame().spacing_m);
    size_t coarse = 0;
    for (size_t i = 0; i < tree.probeCount(); ++i) {
      if (tree.probeSpacing(i) == finest) continue;
      ++coarse;
      const PositionM p = tree.probePosition(i);
      const glm::dvec3 centre(p[0], p[1], p[2]), half(tree.probeSpacing(i));
      ASSERT_GT(sampledDistance(scene, centre - half, centre + half), 0.0) << "seed " << seed << ", probe " << i;
    }
    EXPECT_GT(coarse, 100u) << "seed " << seed;
  }
}

TEST(ProbePlacement, NoGrowthIsAUniformGrid) {
  const Scene scene = boxScene({-3, 1, 10}, {9, 5, 31});
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const ProbeTree tree = placeProbes(scene, {.density_growth = 0.0}, seed);
    const double spacing = tree.frame().spacing_m;
    size_t expected = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double first = tree.frame().first_m[axis], low[3] = {-3, 1, 10}, high[3] = {9, 5, 31};
      expected *= static_cast<size_t>(std::floor((high[axis] - first) / spacing) - std::floor((low[axis] - first) / spacing)) + 2;
    }
    EXPECT_EQ(tree.probeCount(), expected) << "seed " << seed;
    tree.forEachCell([&](const ProbeCell& cell) { ASSERT_EQ(cell.side, 1) << "seed " << seed; });
  }
}

// Two probes along a side are one spacing, nine are eight; no side of these is a whole number of any power of two.
TEST(ProbePlacement, AlignedLatticeHasProbesOnTheCornersOfItsExtent) {
  const Scene scene = boxScene({-1, 0, -1}, {1, 2, 1});
  const ExtentBox extent{{-0.95, 0.05, -0.95}, {0.95, 1.95, 0.95}};
  for (const int cells : {1, 8}) {
    const double spacing = 1.9 / cells;
    ProbePlacementOptions options{.spacing_min_m = spacing, .spacing_max_m = spacing, .density_growth = 0.0};
    options.align_lattice = true;
    options.extent = extent;
    for (uint64_t seed = 0; seed < 3; ++seed) {
      const ProbeTree tree = placeProbes(scene, options, seed);
      EXPECT_EQ(tree.cellCount(), static_cast<size_t>(cells * cells * cells));
      EXPECT_EQ(tree.probeCount(), static_cast<size_t>((cells + 1) * (cells + 1) * (cells + 1)));
      const PositionM first = tree.probePosition(0), last = tree.probePosition(tree.probeCount() - 1);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(first[axis] + scene.origin_m[axis], extent.low_m[axis], 1e-12);
        // the spacing is rounded to a float
        EXPECT_NEAR(last[axis] + scene.origin_m[axis], extent.high_m[axis], 1.9 * 0x1p-23);
      }
    }
  }
}

TEST(ProbePlacement, IsTheSameOnEveryMachine) {
  // golden: one spacing, so that no logarithm is taken
  const ProbeTree tree = placeProbes(infiniteWall(), {.spacing_min_m = 1.5, .spacing_max_m = 1.5}, 7);
  uint64_t hash = 0;
  for (size_t i = 0; i < tree.probeCount(); ++i) {
    const LatticePoint p = tree.probeLattice(i);
    hash = mixSeed(hash, static_cast<uint64_t>(p[0]) << 32 | static_cast<uint64_t>(p[1]), static_cast<uint64_t>(p[2]),
                   static_cast<uint64_t>(tree.probeSpacing(i) * 2.0f));
  }
  EXPECT_EQ(tree.probeCount(), 19044u);
  EXPECT_EQ(hash, 0xc9785aa997d7f028u);
}

TEST(ProbePlacement, HasProbesOnBothSidesOfAFlatSheet) {
  const Scene scene = terrainSheet(2.0f, Sides::one);
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const ProbeTree tree = placeProbes(scene, {}, seed);
    ProbesAround around;
    Random random(seed);
    for (int i = 0; i < 200; ++i) {
      const glm::dvec3 p = randomIn({-50, 1.31, -50}, {50, 2.69, 50}, random);
      ASSERT_TRUE(tree.lookUp(positionOf(p), &around)) << "seed " << seed << ": " << p.x << ", " << p.y << ", " << p.z;
    }
    double low = 1e9, high = -1e9;
    for (size_t i = 0; i < tree.probeCount(); ++i) {
      low = std::min(low, tree.probePosition(i)[1]);
      high = std::max(high, tree.probePosition(i)[1]);
    }
    EXPECT_TRUE(low < 2.0 && high > 2.0) << "seed " << seed << ": " << low << " to " << high;
  }
}

TEST(ProbePlacement, TakesScenesOfAnySizeAndPlaceAndEmptyOnesWithAnExtent) {
  EXPECT_EQ(placeProbes(Scene{}, {}, 1).probeCount(), 0u);
  ProbePlacementOptions options;
  options.extent = ExtentBox{glm::dvec3(0), glm::dvec3(1)};
  const ProbeTree tree = placeProbes(Scene{}, options, 1);
  ProbesAround around;
  ASSERT_TRUE(tree.lookUp({0.5, 0.5, 0.5}, &around));
  EXPECT_EQ(around.cell.side, kRootSide);
  const ProbeTree small = placeProbes(boxScene(glm::vec3(-5e-4f), glm::vec3(5e-4f)), {}, 1);
  EXPECT_TRUE(small.lookUp({0, 0, 0}, &around));
  EXPECT_LE(small.probeCount(), 125u);

  // a sheet of 100 km, and one triangle
  const float far = 5e4f;
  const Scene sheet = SceneOfFaces().addTriangle({-far, 0, -far}, {far, 0, -far}, {0, 0, far}).finish();
  const ProbeTree large = placeProbes(sheet, {.spacing_min_m = 100, .spacing_max_m = 100}, 1);
  EXPECT_TRUE(large.lookUp({0, 0, 0}, &around));

  // the same tree wherever the scene's origin stands; the extent is in world coordinates
  Scene scene = boxScene(glm::vec3(-2), glm::vec3(2));
  const ProbeTree here = placeProbes(scene, {}, 1);
  scene.origin_m = {1e5, -1e5, 1e5};
  EXPECT_EQ(placeProbes(scene, {}, 1).frame().first_m, here.frame().first_m);
  options.extent = ExtentBox{scene.origin_m - 2.0, scene.origin_m + 2.0};
  const ProbeTree there = placeProbes(scene, options, 1);
  EXPECT_EQ(there.frame().first_m, here.frame().first_m);
  EXPECT_EQ(there.probeCount(), here.probeCount());
}

std::string errorOf(const Scene& scene, const ProbePlacementOptions& options) {
  return errorOfCall<UsageError>([&] { placeProbes(scene, options, 1); });
}

TEST(ProbePlacement, NamesASpacingThatFitsWhenThereAreTooManyProbes) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Random random(seed);
    const glm::vec3 half = randomIn(glm::dvec3(2), glm::dvec3(20), random);
    ProbePlacementOptions options{.spacing_min_m = 0.1, .spacing_max_m = 0.1, .density_growth = 0.5 * double(seed % 3)};
    options.max_probes = 2000;
    const Scene scene = boxScene(-half, half);
    const std::string error = errorOf(scene, options);
    const std::string before = "finest spacing of ";
    const size_t at = error.find(before);
    ASSERT_NE(at, std::string::npos) << "seed " << seed << ": " << error;
    options.spacing_min_m = options.spacing_max_m = std::stod(error.substr(at + before.size()));
    for (uint64_t draw = 0; draw < 20; ++draw) {
      EXPECT_LE(placeProbes(scene, options, draw).probeCount(), 2000u) << error;
    }
  }
}

// A room is small enough for half a metre, a level is not, and a world not even for one.
TEST(ProbePlacement, ChoosesASpacingByWhatItTakes) {
  const ProbePlacementOptions options{.density_growth = 0.5};
  const auto chosenFor = [&](const glm::vec3& sides) { return chooseSpacing(boxScene(glm::vec3(0), sides), options); };
  const ChosenSpacing room = chosenFor({8, 3, 6}), tiny = chosenFor({0.8f, 0.3f, 0.6f}), world = chosenFor({3000, 30, 3000});
  EXPECT_EQ(room.spacing_m, 0.5);
  EXPECT_LE(room.probes, kManyProbes);
  EXPECT_NEAR(room.finer_m, 0.354, 1e-3);
  EXPECT_NEAR(room.coarser_m, 0.707, 1e-3);
  EXPECT_GT(room.probes_of_finer, room.probes);
  EXPECT_LT(room.probes_of_coarser, room.probes);
  EXPECT_NEAR(tiny.spacing_m, 0.1, 1e-6);
  EXPECT_GT(world.spacing_m, 1.0);
  EXPECT_LE(world.probes, kMostChosenProbes);
  EXPECT_GT(world.probes_of_finer, kMostChosenProbes);
  // between them a metre, however many probes it takes up to there
  double last = 0.0;
  for (const float side : {10.0f, 20.0f, 40.0f, 80.0f, 160.0f, 320.0f}) {
    const ChosenSpacing chosen = chosenFor({side, 6, side});
    EXPECT_GE(chosen.spacing_m, last) << side;
    EXPECT_TRUE(chosen.probes <= kManyProbes || chosen.spacing_m >= 1.0)
        << side << ": " << chosen.spacing_m << " m, " << chosen.probes;
    last = chosen.spacing_m;
  }
  EXPECT_EQ(chooseSpacing(Scene(), options).spacing_m, 1.0);
}

// The estimate by which what is far too much is refused, from twice the limit on: 30 % off at most. Only that refusal names a number.
void expectGoodEstimate(const Scene& scene, ProbePlacementOptions options) {
  const auto count = static_cast<double>(placeProbes(scene, options, 1).probeCount());
  const auto isRefusedByEstimate = [&](double limit) {
    options.max_probes = static_cast<uint64_t>(limit);
    return errorOf(scene, options).find("about") != std::string::npos;
  };
  EXPECT_TRUE(isRefusedByEstimate(0.5 * 0.7 * count)) << count;
  EXPECT_FALSE(isRefusedByEstimate(0.5 * 1.3 * count)) << count;
}

// A metre apart but in three boxes: finer, coarser in spite of walls, and none.
TEST(ProbePlacement, KeepsToTheBoxesOfTheScenesAuthor) {
  Scene scene = boxScene({-8, -8, -8}, {8, 8, 8});
  const ExtentBox fine{glm::dvec3(-2), glm::dvec3(2)}, coarse{glm::dvec3(0, -20, -20), glm::dvec3(20)},
      none{glm::dvec3(-20), glm::dvec3(-4, 20, 20)};
  ProbePlacementOptions options;
  options.density = {{fine, 0.25, "fine"}, {coarse, 4.0, "coarse"}, {none, 0.0, "none"}};
  for (DensityBox& of : options.density) of.box = {of.box.low_m + scene.origin_m, of.box.high_m + scene.origin_m};
  options.spacing_min_m = options.spacing_max_m = 1.0;
  const ProbeTree tree = placeProbes(scene, options, 1);
  EXPECT_DOUBLE_EQ(tree.frame().spacing_m, 0.25);
  std::set<double> outside, in_coarse;
  tree.forEachCell([&](const ProbeCell& cell) {
    const double side_m = tree.frame().spacing_m * cell.side;
    const glm::dvec3 low = lowCorner(tree, cell), high = low + side_m;
    const auto overlaps = [&](const ExtentBox& box) {
      return glm::all(glm::lessThan(low, box.high_m)) && glm::all(glm::lessThan(box.low_m, high));
    };
    EXPECT_TRUE(high.x > none.high_m.x);
    if (overlaps(fine)) {
      EXPECT_DOUBLE_EQ(side_m, 0.25);
    }
    // a node of the tree is divided as a whole: a metre, here
    if (overlaps({fine.low_m - 1.0, fine.high_m + 1.0})) return;
    (overlaps(coarse) ? in_coarse : outside).insert(side_m);
  });
  EXPECT_EQ(*outside.begin(), 1.0);
  EXPECT_EQ(*in_coarse.rbegin(), 4.0);
  expectGoodEstimate(scene, options);

  // a box that is small beside the extent counts in the estimate, too, and the spacing that is chosen is not its own
  options.density = {{{scene.origin_m - 0.7, scene.origin_m + 0.7}, 0.04, "small"}};
  expectGoodEstimate(scene, options);
  EXPECT_EQ(chooseSpacing(scene, options).spacing_m, chooseSpacing(scene, ProbePlacementOptions()).spacing_m);
  // and once, however many stand in each other
  options.density.resize(20, options.density[0]);
  expectGoodEstimate(scene, options);
  // flat ones, too
  options.density.resize(1);
  const DensityBox small = options.density[0];
  options.density[0].box.high_m.y = options.density[0].box.low_m.y;
  options.density.resize(20, options.density[0]);
  expectGoodEstimate(scene, options);
  options.density = {small};
  options.density[0].spacing_m = 0.02;
  EXPECT_NE(errorOf(scene, options).find("nlg_density of 'small'"), std::string::npos);
  // what lies beyond the extent changes nothing
  options.density = {{{scene.origin_m + 50.0, scene.origin_m + 60.0}, 0.25, "far"}};
  EXPECT_EQ(placeProbes(scene, options, 1).frame().spacing_m, 1.0);
}

// Two strays kilometres off on either side; the room by itself has a few hundred probes.
TEST(ProbePlacement, NamesTheObjectsThatMakeASceneTooLarge) {
  Scene scene = boxScene(glm::vec3(0), glm::vec3(8, 3, 6));
  scene.objects = {{"room", 0, static_cast<uint32_t>(scene.triangles.size())}};
  const auto addStray = [&](const char* name, float x) {
    const auto first = static_cast<uint32_t>(scene.positions.size());
    for (const glm::vec3 corner : {glm::vec3(x, 0, 0), glm::vec3(x + 1, 0, 0), glm::vec3(x, 0, 1)})
      scene.positions.push_back(corner);
    scene.objects.push_back({name, static_cast<uint32_t>(scene.triangles.size()), 1});
    scene.triangles.push_back({first, first + 1, first + 2});
    scene.triangle_material.push_back(0);
  };
  addStray("barrel", 3000.0f);
  addStray("crate", -5000.0f);
  ProbePlacementOptions options{.spacing_min_m = 0.5, .spacing_max_m = 0.5};
  options.max_probes = 1000;
  const std::string error = errorOf(scene, options);
  EXPECT_NE(error.find("without 'crate', 'barrel' 8 x 3 x 6 m; a box named nlg_extent"), std::string::npos) << error;
  options.extent = ExtentBox{glm::dvec3(0), glm::dvec3(500, 3, 6)};
  EXPECT_EQ(errorOf(scene, options).find("crate"), std::string::npos) << "an extent that was asked for is nobody else's";
}

}  // namespace
}  // namespace nlg
