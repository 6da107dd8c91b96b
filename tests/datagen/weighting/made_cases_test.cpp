// Functions in scenes whose air, solid and lines of sight are known by formula: walls with slits, wires, bars, keyholes, lamp shades; and
// whether anything but the scene has a say in a function.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "datagen/probes/probe_placement.h"
#include "datagen/weighting/weighting_builder.h"
#include "scene/scene_source.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

// Closed boxes, all turned together around the probe: what a formula says of boxes along the axes holds of them.
class TurnedBoxes {
 public:
  // radians, around the vertical and then around x
  TurnedBoxes(double turn, double tilt)
      : turned_(glm::dmat3(1, 0, 0, 0, std::cos(tilt), std::sin(tilt), 0, -std::sin(tilt), std::cos(tilt)) *
                glm::dmat3(std::cos(turn), 0, -std::sin(turn), 0, 1, 0, std::sin(turn), 0, std::cos(turn))) {}

  void add(const glm::dvec3& low, const glm::dvec3& high) { boxes_.push_back({low, high}); }

  Scene scene() const {
    SceneOfFaces faces;
    for (const Box& box : boxes_) faces.addBox(glm::vec3(box.low), glm::vec3(box.high));
    Scene scene = faces.finish();
    for (glm::vec3& position : scene.positions) position = glm::vec3(turned_ * glm::dvec3(position));
    return scene;
  }

  // Of a place of the turned scene. clear: farther from every face than rounding
  bool isSolid(const glm::dvec3& place) const {
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const Box& box) { return box.depth(turnedBack(place)) > 0.0; });
  }
  bool isClear(const glm::dvec3& place) const {
    return std::all_of(boxes_.begin(), boxes_.end(),
                       [&](const Box& box) { return std::abs(box.depth(turnedBack(place))) > 1e-5; });
  }
  glm::dvec3 turnedBack(const glm::dvec3& p) const { return p * turned_; }

 private:
  struct Box {
    glm::dvec3 low, high;
    // Above 0 inside.
    double depth(const glm::dvec3& p) const {
      double least = 1e9;
      for (int axis = 0; axis < 3; ++axis) least = std::min({least, p[axis] - low[axis], high[axis] - p[axis]});
      return least;
    }
  };

  glm::dmat3 turned_;
  std::vector<Box> boxes_;
};

GeneratedFunction functionAtOrigin(const Scene& scene) {
  const RayScene rays(scene);
  WeightingBuilder builder(rays, {});
  GeneratedFunction function;
  EXPECT_EQ(builder.build(glm::dvec3(0.0), 1.0f, &function), ProbeOutcome::function);
  return function;
}

glm::dvec3 pointPlace(size_t point) {
  const LocalPoint& at = supportPattern().points[point];
  return {at[0], at[1], at[2]};
}

struct Case {
  std::string name;
  TurnedBoxes boxes;
};

// Air and solid are what they are made as, all that a straight line reaches has the tent, and nothing else more than it.
void expectAsMade(const Case& made) {
  const Scene scene = made.boxes.scene();
  const RayScene rays(scene);
  const GeneratedFunction function = functionAtOrigin(scene);
  for (size_t p = 0; p < kSupportPointCount; ++p) {
    const glm::dvec3 place = pointPlace(p);
    if (!made.boxes.isClear(place)) continue;
    const bool is_solid = made.boxes.isSolid(place);
    ASSERT_EQ(function.valid[p], !is_solid) << made.name << ", point " << place.x << ' ' << place.y << ' ' << place.z;
    const float bare = tent(supportPattern().points[p]);
    if (!is_solid && !rays.isBlocked(glm::vec3(0.0f), glm::vec3(place))) {
      ASSERT_EQ(function.phi[p], bare) << made.name << ", point " << p;
    }
    if (is_solid) {
      ASSERT_EQ(function.phi[p], 0.0f) << made.name << ", point " << p;
    }
  }
}

constexpr double kFar = 5.0;
constexpr double kWall = 0.31, kThick = 0.16;

// A wall with a slit, above and below the slit's middle at this height.
TurnedBoxes wallWithSlit(double turn, double tilt, double height, double width) {
  TurnedBoxes boxes(turn, tilt);
  boxes.add({kWall, -kFar, -kFar}, {kWall + kThick, height - width / 2, kFar});
  boxes.add({kWall, height + width / 2, -kFar}, {kWall + kThick, kFar, kFar});
  return boxes;
}

std::vector<Case> slits() {
  std::vector<Case> cases;
  int n = 0;
  for (const double width : {0.01, 0.02, 0.05, 0.1}) {
    for (const double turn : {0.0, 0.4, 0.785, 1.3, 2.2}) {
      for (const double tilt : {0.0, 0.35, 1.1}) {
        const double height = 0.11 * (n++ % 5) - 0.2;
        cases.push_back(
            {"slit of " + std::to_string(width) + " turned by " + std::to_string(turn) + ", tilted by " + std::to_string(tilt),
             wallWithSlit(turn, tilt, height, width)});
      }
    }
  }
  return cases;
}

TEST(MadeCases, SlitsOfAllAnglesLetThroughWhatALineReaches) {
  const std::vector<Case> cases = slits();
  ASSERT_EQ(cases.size(), 60u);
  for (const Case& made : cases) expectAsMade(made);
}

TEST(MadeCases, WhereTheSlitIsClosedNothingPasses) {
  for (const double turn : {0.0, 0.4, 0.785, 1.3, 2.2}) {
    for (const double tilt : {0.0, 0.35, 1.1}) {
      const Case closed = {"closed", wallWithSlit(turn, tilt, 0.05, 0.0)};
      expectAsMade(closed);
      const GeneratedFunction function = functionAtOrigin(closed.boxes.scene());
      for (size_t p = 0; p < kSupportPointCount; ++p) {
        if (closed.boxes.turnedBack(pointPlace(p)).x < kWall) continue;
        ASSERT_EQ(function.phi[p], 0.0f) << "turned by " << turn << ", tilted by " << tilt << ", point " << p;
      }
    }
  }
}

TEST(MadeCases, WiresBarsAndKeyholesAreWhatTheyAre) {
  std::vector<Case> cases;
  for (const double turn : {0.0, 0.5, 1.1}) {
    TurnedBoxes wires(turn, 0.2), bars(turn, 0.0), door(turn, 0.1);
    for (int i = 0; i < 8; ++i) {
      const double z = -0.9 + 0.23 * i;
      wires.add({0.33, -kFar, z}, {0.332, kFar, z + 0.002});
      bars.add({0.3, -kFar, z}, {0.33, kFar, z + 0.03});
    }
    // a door with a keyhole of 1 by 3 cm
    door.add({0.25, -kFar, -kFar}, {0.29, -0.2, kFar});
    door.add({0.25, -0.17, -kFar}, {0.29, kFar, kFar});
    door.add({0.25, -0.2, -kFar}, {0.29, -0.17, 0.1});
    door.add({0.25, -0.2, 0.11}, {0.29, -0.17, kFar});
    cases.push_back({"wires", wires});
    cases.push_back({"bars", bars});
    cases.push_back({"door", door});
  }
  for (const Case& made : cases) expectAsMade(made);
}

// A shade of one-sided sheets, open below and above, whose outside alone is seen as its front.
TEST(MadeCases, ALampShadeTakesNoAirAroundIt) {
  for (const double side : {0.12, 0.2, 0.3}) {
    SceneOfFaces faces;
    const auto x = static_cast<float>(0.4 - side / 2), X = static_cast<float>(0.4 + side / 2);
    const auto z = static_cast<float>(-side / 2), Z = static_cast<float>(side / 2);
    const float low = -0.17f, high = 0.13f;
    const auto sides = boxSides({x, low, z}, {X, high, Z});
    for (const size_t i : {0, 1, 4, 5}) faces.addQuad(sides[i][0], sides[i][1], sides[i][2], sides[i][3]);
    const Scene scene = faces.finish();
    const RayScene rays(scene);
    const GeneratedFunction function = functionAtOrigin(scene);
    for (size_t p = 0; p < kSupportPointCount; ++p) {
      const glm::dvec3 at = pointPlace(p);
      const bool is_inside = at.x > x && at.x < X && at.z > z && at.z < Z && at.y > low && at.y < high;
      if (is_inside) continue;
      ASSERT_TRUE(function.valid[p]) << "side " << side << ", point " << at.x << ' ' << at.y << ' ' << at.z;
      if (!rays.isBlocked(glm::vec3(0.0f), glm::vec3(at))) {
        ASSERT_EQ(function.phi[p], tent(supportPattern().points[p])) << "side " << side << ", point " << p;
      }
    }
  }
}

// Rays leave no doubt inside: a crack that a link passes no longer makes it air.
TEST(MadeCases, ACrackInAShellLetsNoAirIn) {
  for (const float crack : {0.001f, 0.005f, 0.01f}) {
    SceneOfFaces faces;
    // the near face, the first one, in two strips
    const auto sides = boxSides({0.25f, -0.6f, -0.6f}, {0.75f, 0.6f, 0.6f});
    for (size_t side = 1; side < 6; ++side) faces.addQuad(sides[side][0], sides[side][1], sides[side][2], sides[side][3]);
    faces.addQuad({0.25f, -0.6f, -0.6f}, {0.25f, -0.6f, 0.6f}, {0.25f, -crack, 0.6f}, {0.25f, -crack, -0.6f});
    faces.addQuad({0.25f, 0.0f, -0.6f}, {0.25f, 0.0f, 0.6f}, {0.25f, 0.6f, 0.6f}, {0.25f, 0.6f, -0.6f});
    const Scene scene = faces.finish();
    const GeneratedFunction function = functionAtOrigin(scene);
    size_t inside = 0;
    for (size_t p = 0; p < kSupportPointCount; ++p) {
      const glm::dvec3 at = pointPlace(p);
      const bool is_inside = at.x > 0.25 && at.x < 0.75 && std::abs(at.y) < 0.6 && std::abs(at.z) < 0.6;
      if (function.seen[p] || !is_inside) continue;
      ++inside;
      ASSERT_FALSE(function.valid[p]) << "crack of " << crack << ", point " << at.x << ' ' << at.y << ' ' << at.z;
    }
    EXPECT_GT(inside, 600u);
  }
}

// Functions of a level, with their sums, by probe.
struct Sampled {
  ProbeOutcome outcome = ProbeOutcome::empty;
  GeneratedFunction function;
  std::vector<uint8_t> sums = std::vector<uint8_t>(kSupportPointCount);
  bool operator==(const Sampled& other) const {
    return outcome == other.outcome && function.phi == other.function.phi && function.valid == other.function.valid &&
           function.seen == other.function.seen && function.open_shell == other.function.open_shell && sums == other.sums;
  }
};

class Level {
 public:
  explicit Level(const std::string& request) : source_(loadScene(request, {})), rays_(source_.scene) {
    ProbePlacementOptions options;
    options.spacing_min_m = options.spacing_max_m = 1.0;
    tree_ = placeProbes(source_.scene, options, 1);
    // some neighbours, from all over the level
    for (uint64_t probe = 0; probe < tree_.probeCount(); ++probe) {
      if (probe / 32 % 4 == 0) probes_.push_back(probe);
    }
  }

  // order   of the probes; each thread has a builder of its own
  std::vector<Sampled> sample(const std::vector<size_t>& order, int threads, bool is_alone = false) const {
    std::vector<std::unique_ptr<WeightingBuilder>> builders;
    for (int t = 0; t < threads; ++t) builders.push_back(std::make_unique<WeightingBuilder>(rays_, DiffusionOptions{}));
    ProbeLattice lattice(tree_.frame());
    std::vector<Sampled> sampled(probes_.size());
    parallelFor(order.size(), threads, [&](uint64_t n, int thread) {
      const uint64_t probe = probes_[order[n]];
      const auto [x, y, z] = tree_.probePosition(probe);
      Sampled& to = sampled[order[n]];
      to.outcome = builders[thread]->build({x, y, z}, tree_.probeSpacing(probe), &to.function, InSolid::by_eye,
                                           is_alone ? nullptr : &lattice);
      if (to.outcome == ProbeOutcome::function) builders[thread]->sumBlend(to.function, to.sums.data());
    });
    return sampled;
  }

  size_t count() const { return probes_.size(); }

 private:
  SceneSource source_;
  RayScene rays_;
  ProbeTree tree_;
  std::vector<uint64_t> probes_;
};

TEST(Sampling, IsTheSameForEveryOrderAndNumberOfThreads) {
  for (const char* request : {"house:3", "kitchen:7"}) {
    const Level level(request);
    std::vector<size_t> order(level.count());
    for (size_t n = 0; n < order.size(); ++n) order[n] = n;
    const std::vector<Sampled> forward = level.sample(order, 1);
    const size_t functions = static_cast<size_t>(
        std::count_if(forward.begin(), forward.end(), [](const Sampled& s) { return s.outcome == ProbeOutcome::function; }));
    EXPECT_GT(functions, 50u) << request;
    std::reverse(order.begin(), order.end());
    EXPECT_TRUE(level.sample(order, 3) == forward) << request;
    std::stable_partition(order.begin(), order.end(), [](size_t n) { return n % 3 == 1; });
    EXPECT_TRUE(level.sample(order, 2) == forward) << request;
  }
}

// A probe that brings a lattice of its own rounds places another way, and no more than that.
TEST(Sampling, IsTheSameForAProbeAlone) {
  const Level level("kitchen:7");
  std::vector<size_t> some;
  for (size_t n = 0; n < level.count(); n += 5) some.push_back(n);
  const std::vector<Sampled> together = level.sample(some, 2), alone = level.sample(some, 2, true);
  size_t points = 0, differ = 0;
  for (const size_t n : some) {
    ASSERT_EQ(together[n].outcome, alone[n].outcome) << n;
    if (together[n].outcome != ProbeOutcome::function) continue;
    for (size_t p = 0; p < kSupportPointCount; ++p) {
      const GeneratedFunction &a = together[n].function, &b = alone[n].function;
      ++points;
      differ += a.valid[p] != b.valid[p] || std::abs(a.phi[p] - b.phi[p]) > 1e-5f ||
                std::abs(together[n].sums[p] - alone[n].sums[p]) > 1;
    }
  }
  EXPECT_GT(points, 20u * kSupportPointCount);
  EXPECT_LT(differ, points / 10000);
}

}  // namespace
}  // namespace nlg
