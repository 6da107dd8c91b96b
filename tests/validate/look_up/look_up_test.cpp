// Two halves of space with a wall between them: where everything that the measurement says is known.

#include "validate/look_up/look_up_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/datagen/hand_built_scenes.h"
#include "validate/look_up/specks.h"

namespace nlg {
namespace {

// The wall stands in the middle between two columns of probes, and reaches further than all supports.
constexpr double kWallX = 0.5, kHalfThickness = 0.01;
constexpr double kShareBound = 1e-6;  // of shares that are made of some ten float roundings each

class LookUpTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { level_ = new Level; }
  static void TearDownTestSuite() { delete level_; }

  struct Level {
    Level()
        : scene([] {
            SceneOfFaces faces;
            faces.addBox({kWallX - kHalfThickness, -50, -50}, {kWallX + kHalfThickness, 50, 50});
            return faces.finish();
          }()),
          rays(scene),
          links(makeLinkTable({})) {
      // probes at whole metres: cells of 1 m around the wall, of 2 m from 4 m on; none beyond 8 m
      const CellJudge judge = [](const ProbeCell& cell) {
        double distance = 0.0;  // from the wall
        for (int axis = 0; axis < 3; ++axis) {
          const int32_t low = cell.low[axis] - 32, high = low + cell.side;
          if (low >= 8 || high <= -8) return CellVerdict::unneeded;
          if (axis == 0) distance = std::max({0.0, low - kWallX, kWallX - high});
        }
        return cell.side == 1 || cell.side <= 0.5 * distance ? CellVerdict::fits : CellVerdict::too_coarse;
      };
      EXPECT_EQ(ProbeTree::build({{-32, -32, -32}, 1.0, {1, 1, 1}}, judge, kMaxTreeProbes, &tree), ProbeTreeStatus::ok);
      const SupportVisibility visibility(rays, links);
      places = drawPlaces({glm::dvec3(-7.5), glm::dvec3(7.5)}, rays, visibility, tree, {4000, 20000, 400000, 1});
      truth = trueWeights(places.positions(), tree, rays, links, {}, 2);
    }
    Scene scene;
    RayScene rays;
    LinkTable links;
    ProbeTree tree;
    Places places;
    std::vector<TrueWeights> truth;
  };

  // All probes with one entry.
  static LightGrid gridOf(uint32_t function) {
    LightGrid grid;
    grid.tree = level_->tree;
    grid.probe_function.assign(grid.tree.probeCount(), function);
    return grid;
  }

  // What target φ says: the tent up to the wall, nothing behind it. A step so steep that float knows nothing between 0 and 1.
  static LightGrid perfectGrid() {
    LightGrid grid = gridOf(kFreeSpace);
    Representation step;
    EXPECT_TRUE(findRepresentation("tent_mlp4", &step));
    grid.representations = {step};
    for (const float side : {-1.0f, 1.0f}) {  // the wall is at this x = side / 2 of the support
      Theta theta(step.thetaCount());
      theta[step.shape().w1()] = -side * 1e7f;
      theta[step.shape().b1()] = 0.5f * 1e7f;
      theta[step.shape().w3()] = 1.0f;
      grid.addFunction(0, theta.data());
    }
    for (size_t probe = 0; probe < grid.probe_function.size(); ++probe) {
      const double x = grid.tree.probePosition(probe)[0];
      if (x == 0.0) grid.probe_function[probe] = 1;
      if (x == 1.0) grid.probe_function[probe] = 0;
    }
    EXPECT_TRUE(checkLightGrid(grid).ok());
    return grid;
  }

  static LookUpFiguresByDistance measure(const LookUp& look_up) {
    return figuresOf(blendsOf(look_up, level_->places.places, level_->truth), level_->places, level_->truth);
  }
  static JumpFigures jumps(const LookUp& look_up) {
    return measureJumps(level_->places.places, level_->tree, level_->rays, look_up, 1);
  }

  // The share that a tent gives to probes behind the wall.
  static double tentLeak(const Place& place) {
    const double x = place.position_m.x;
    return x > 0.0 && x < 1.0 ? std::min(x, 1.0 - x) : 0.0;
  }

  static Level* level_;
};
LookUpTest::Level* LookUpTest::level_ = nullptr;

TEST_F(LookUpTest, PlacesAreInAirAndKnowTheirDistance) {
  const Places& places = level_->places;
  std::array<uint64_t, kDistanceClassCount> kept{};
  for (const Place& place : places.places) {
    const double distance = std::abs(place.position_m.x - kWallX) - kHalfThickness;
    ASSERT_GE(distance, 0.0);
    const size_t expected = distance < 0.05 ? 0 : distance < 0.2 ? 1 : distance < 0.5 ? 2 : 3;
    const bool on_border = std::any_of(kDistanceBordersM.begin(), kDistanceBordersM.end(),
                                       [&](double border) { return std::abs(distance - border) < 1e-5; });
    if (!on_border) {
      ASSERT_EQ(place.distance_class, expected) << distance;
    }
    ++kept[place.distance_class];
  }
  EXPECT_EQ(kept, places.kept);
  for (const uint64_t count : kept) EXPECT_EQ(count, 1000u);
  // binomial: five deviations of 20,000 draws, at most
  const double volume = 15.0, air = volume - 2 * kHalfThickness, bound = 5 * 0.5 / std::sqrt(20000.0);
  EXPECT_NEAR(static_cast<double>(places.in_solid) / 20000, 1.0 - air / volume, bound);
  EXPECT_EQ(places.drawn, 20000u);
  EXPECT_EQ(places.disputed, 0u);
  EXPECT_EQ(places.outside, 0u);
  const double widths[] = {0.1, 0.3, 0.6, air - 1.0};
  for (size_t c = 0; c < kDistanceClassCount; ++c) EXPECT_NEAR(places.air_share[c], widths[c] / air, bound) << c;
}

TEST_F(LookUpTest, CountsPlacesOutsideTheTree) {
  const SupportVisibility visibility(level_->rays, level_->links);
  // half of this box lies beyond the last probes, at x = 8
  const Places places = drawPlaces({{6, -1, -1}, {10, 1, 1}}, level_->rays, visibility, level_->tree, {400, 4000, 4000, 1});
  EXPECT_EQ(places.in_air, 4000u);
  EXPECT_NEAR(static_cast<double>(places.outside) / 4000, 0.5, 5 * 0.5 / std::sqrt(4000.0));
  for (const Place& place : places.places) ASSERT_LT(place.position_m.x, 8.0);
}

TEST_F(LookUpTest, TargetsAreTentsUpToTheWall) {
  for (size_t i = 0; i < level_->truth.size(); ++i) {
    const glm::dvec3 at = level_->places.places[i].position_m;
    ProbesAround around;
    ASSERT_TRUE(level_->tree.lookUp({at.x, at.y, at.z}, &around));
    for (int c = 0; c < kCornerCount; ++c) {
      const double probe_x = level_->tree.probePosition(around.corners[c].probe)[0];
      const bool same_side = (probe_x < kWallX) == (at.x < kWallX);
      const float expected = same_side ? tent(around.corners[c].local) * around.corners[c].tent_ratio : 0.0f;
      ASSERT_EQ(level_->truth[i].probe[c], around.corners[c].probe);
      ASSERT_EQ(level_->truth[i].target[c], expected) << "x = " << at.x << ", probe at " << probe_x;
      ASSERT_EQ(level_->truth[i].seen[c], expected) << "x = " << at.x << ", probe at " << probe_x;
      ASSERT_EQ(level_->truth[i].is_seen[c], same_side) << "x = " << at.x << ", probe at " << probe_x;
    }
  }
}

TEST_F(LookUpTest, FindsNothingWrongWithAPerfectGrid) {
  const LightGrid grid = perfectGrid();
  // what a probe has of its tent is nothing or all of it, of which the residue takes nothing
  const double bound = kShareBound;
  const LookUpFiguresByDistance figures = measure(lookUpOf(grid, glm::dvec3(0)));
  const auto expectPerfect = [bound](const LookUpFigures& f) {
    EXPECT_GE(f.places, 1000u);
    EXPECT_EQ(f.unlit, 0.0);
    EXPECT_EQ(f.unlit_target, 0.0);
    EXPECT_EQ(f.seen_by_none, 0.0);
    EXPECT_LE(f.rmse, bound);
    EXPECT_LE(f.wrong_p99, bound);
    EXPECT_LE(f.wrong_to_seen, bound);
    EXPECT_EQ(f.leak_mean, 0.0);
    EXPECT_EQ(f.leak_p99, 0.0);
  };
  expectPerfect(figures.all);
  for (const LookUpFigures& f : figures.by_class) expectPerfect(f);
}

// Between the columns at x = 0 and the wall only those see a place. Where their functions say .06 of the tent, a look-up takes the
// light of those behind the wall, which say all of theirs.
TEST_F(LookUpTest, SpecksAreLitByWhatNoProbeThatSeesThemSays) {
  LightGrid grid = perfectGrid();
  Theta faint(grid.representations[0].thetaCount());
  faint[grid.representations[0].shape().b3()] = std::log(0.06f / 0.94f);  // of a sigmoid
  grid.addFunction(0, faint.data());
  for (size_t probe = 0; probe < grid.probe_function.size(); ++probe) {
    if (grid.tree.probePosition(probe)[0] == 0.0) grid.probe_function[probe] = 2;
    if (grid.tree.probePosition(probe)[0] == 1.0) grid.probe_function[probe] = kFreeSpace;
  }
  const ExtentBox extent = {glm::dvec3(-1.5, -3.0, -3.0), glm::dvec3(1.5, 3.0, 3.0)};
  SpeckOptions options;
  options.places = 20000;
  options.threads = 2;
  const Specks found = findSpecks(grid, level_->tree, {}, level_->rays, extent, options);
  EXPECT_EQ(found.looked_up, options.places);
  // of the extent's 3 m along x these are .49; five standard deviations of the share are less than .02
  EXPECT_NEAR(static_cast<double>(found.count) / 20000.0, 0.49 / 3.0, 0.02);
  EXPECT_EQ(found.first.size(), options.most_listed);
  for (const Speck& speck : found.first) {
    // before x = 0 a quarter of the distance is tent of one of the next column's probes, who say all of it
    EXPECT_GT(speck.position_m.x, -4.0 * kSpeckLeastTent);
    EXPECT_LT(speck.position_m.x, kWallX);
    EXPECT_LT(speck.largest_share, kSpeckShare);
    EXPECT_GE(speck.seen_by, 1);
  }
  SpeckOptions one_thread = options;
  one_thread.threads = 1;
  EXPECT_EQ(findSpecks(grid, level_->tree, {}, level_->rays, extent, one_thread).count, found.count);

  EXPECT_EQ(findSpecks(perfectGrid(), level_->tree, {}, level_->rays, extent, options).count, 0u);
  EXPECT_EQ(findSpecks(gridOf(kFreeSpace), level_->tree, {}, level_->rays, extent, options).count, 0u) << "a leak, but no speck";
}

TEST_F(LookUpTest, MeasuresExactlyWhatBareTentsLeak) {
  const LightGrid grid = gridOf(kFreeSpace);
  const LookUpFiguresByDistance figures = measure(lookUpOf(grid, glm::dvec3(0)));
  double all = 0.0;
  for (uint8_t c = 0; c < kDistanceClassCount; ++c) {
    double leak = 0.0, squares = 0.0, largest = 0.0;
    for (const Place& place : level_->places.places) {
      if (place.distance_class != c) continue;
      const double share = tentLeak(place);
      leak += share / 1000;
      all += share * level_->places.weight(c);
      largest = std::max(largest, share);
      // behind the wall there are 4 probes; what they have is missing from the 4 before it, in the same bilinear shares
      double bilinear = 1.0;
      for (int axis = 1; axis < 3; ++axis) {
        const double d = place.position_m[axis] - std::floor(place.position_m[axis]);
        bilinear *= d * d + (1 - d) * (1 - d);
      }
      squares += 2 * share * share * bilinear / 8 / 1000;
    }
    const LookUpFigures& f = figures.by_class[c];
    EXPECT_NEAR(f.wrong_mean, leak, kShareBound) << int{c};
    EXPECT_NEAR(f.wrong_to_seen, leak, kShareBound) << int{c};
    EXPECT_NEAR(f.leak_mean, leak, kShareBound) << int{c};
    EXPECT_NEAR(f.rmse, std::sqrt(squares), kShareBound) << int{c};
    EXPECT_LE(f.leak_p99, largest + kShareBound) << int{c};
    EXPECT_GE(f.leak_p99, leak - kShareBound) << int{c};
  }
  EXPECT_NEAR(figures.all.wrong_mean, all, kShareBound);
  EXPECT_NEAR(figures.all.leak_mean, all, kShareBound);
  EXPECT_GT(figures.by_class[0].wrong_mean, 0.4);
}

TEST_F(LookUpTest, CountsLightThatIsLostAsAllWrong) {
  const LightGrid grid = gridOf(kNoWeight);
  const LookUpFigures figures = measure(lookUpOf(grid, glm::dvec3(0))).all;
  EXPECT_NEAR(figures.unlit, 1.0, 1e-12);
  EXPECT_NEAR(figures.wrong_mean, 1.0, 1e-12);
  EXPECT_EQ(figures.leak_mean, 0.0);
}

TEST_F(LookUpTest, FindsASabotagedLookUp) {
  // the perfect grid, read as if every cell were turned round its middle along x
  const LightGrid grid = perfectGrid();
  const auto turned = [&](const glm::dvec3& at, ProbeWeights* weights) {
    ProbesAround around;
    if (!lookUpOf(grid, glm::dvec3(0))(at, weights) || !grid.tree.lookUp({at.x, at.y, at.z}, &around)) return false;
    for (int i = 0; i < weights->count; ++i) {
      for (int c = 0; c < kCornerCount; ++c) {
        if (around.corners[c].probe != weights->probe[i]) continue;
        weights->probe[i] = around.corners[c ^ 1].probe;
        break;
      }
    }
    return true;
  };
  const LookUpFigures beside_wall = measure(turned).by_class[0];
  EXPECT_NEAR(beside_wall.wrong_mean, 1.0, kShareBound);
  EXPECT_NEAR(beside_wall.leak_mean, 1.0, kShareBound);
  EXPECT_GT(jumps(turned).largest, 0.9);

  // every probe around counts alike: half of them change at every face
  const auto equal = [&](const glm::dvec3& at, ProbeWeights* weights) {
    ProbesAround around;
    if (!grid.tree.lookUp({at.x, at.y, at.z}, &around)) return false;
    weights->count = 8;
    for (int c = 0; c < kCornerCount; ++c) weights->probe[c] = around.corners[c].probe, weights->weight[c] = 1.0f;
    return true;
  };
  EXPECT_NEAR(jumps(equal).mean, 0.5, 1e-6);
  EXPECT_NEAR(jumps(equal).largest, 0.5, 1e-6);
}

TEST_F(LookUpTest, SeesNoJumpWhateverFunctionsSayAtTheirBorder) {
  LightGrid grid = gridOf(0);
  grid.representations = {Representation::mlp(), Representation::productField(3)};
  Theta one(ThetaLayout::count);
  one[ThetaLayout::b3] = 0.75f;
  grid.addFunction(0, one.data());
  const BorderFigures border = measureBorder(grid);
  EXPECT_EQ(border.functions, 1u);
  EXPECT_EQ(border.mean, 0.75);
  EXPECT_EQ(border.p99, 0.75);
  EXPECT_EQ(border.largest, 0.75);
  // weights up to 2^-20 of a side from the face, as shares of sums of at least 1/8
  const JumpFigures figures = jumps(lookUpOf(grid, glm::dvec3(0)));
  EXPECT_GT(figures.segments, 1000u);
  EXPECT_GT(figures.hanging, 10u);
  EXPECT_LE(figures.largest, 8 * 0x1p-19);
}

}  // namespace
}  // namespace nlg
