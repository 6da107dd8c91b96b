#include "validate/solved/joint_solve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// A room of the given size, walls, floor and ceiling a metre thick; with or without a thin wall at x = 1.55.
SmallScene room(const glm::vec3& high, bool with_wall) {
  SmallScene small = makeSmallScene("two_rooms");
  small.solids.clear();
  small.room = {glm::vec3(-0.45f), high};
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      Bounds slab{small.room.min - 1.0f, high + 1.0f};
      (upper ? slab.min : slab.max)[axis] = upper ? high[axis] : small.room.min[axis];
      small.solids.push_back(slab);
    }
  }
  if (with_wall) small.solids.push_back({{1.53f, -0.45f, -0.45f}, {1.57f, high.y, high.z}});
  small.lattice = {glm::vec3(-1.0f), glm::ivec3(glm::ceil(high)) + 2, 1.0f};
  small.slice_m = 0.5f;
  return small;
}

struct Fixture {
  Fixture(const glm::vec3& high, bool with_wall, int points_a_cell)
      : small(room(high, with_wall)),
        rays(small.makeScene()),
        points(makeSamplePoints(small, {points_a_cell, points_a_cell / 2})),
        links(linkPoints(rays, points)) {}

  Signals signals(int count, const std::function<double(int, const glm::vec3&)>& value) const {
    Signals result;
    result.count = count;
    for (const glm::vec3& at : points.position_m) {
      for (int s = 0; s < count; ++s) result.value.push_back(static_cast<float>(value(s, at)));
    }
    return result;
  }

  SmallScene small;
  RayScene rays;
  SamplePoints points;
  PointLinks links;
};

// Lighting that eight probes at the corners of a cell reproduce by the tent, and by nothing else: all products of coordinates.
double product(int s, const glm::vec3& at) { return (s & 1 ? at.x : 1.0) * (s & 2 ? at.y : 1.0) * (s & 4 ? at.z : 1.0); }

double meanSquare(const SamplePoints& points, const std::vector<double>& errors, PointUse use) {
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0; i < errors.size(); ++i) {
    if (points.use[i] == use) sum += errors[i], ++count;
  }
  return sum / count;
}

TEST(JointSolve, LeavesNoErrorUnderConstantLighting) {
  const Fixture box({2.4f, 1.4f, 1.4f}, false, 24);
  const Signals signals = box.signals(3, [](int s, const glm::vec3&) { return 1.0 + s; });
  const SolvedFunctions solved = solveFunctions(box.points, box.links, signals, {20, 0.03, 1e-3, 0.1});
  const std::vector<float> probes =
      solveProbes(box.points, solved.weights, signals, pointsOf(box.points, {PointUse::fit, PointUse::slice}));
  const std::vector<double> errors = squaredErrors(box.points, solved.weights, probes, signals);
  // the ridge of the least squares, 1e-7 of the mean diagonal, pulls the least used probe by less than a thousandth
  for (size_t i = 0; i < errors.size(); ++i) ASSERT_LT(errors[i], 1e-6) << "point " << i;
}

TEST(JointSolve, GivesBackNearlyTheTentWhereLightingVariesLinearly) {
  // all cells between probes in air, so that no probe is missing at the room's walls
  SmallScene small = room({2.4f, 2.4f, 2.4f}, false);
  small.lattice = {glm::vec3(-0.44f), {3, 3, 3}, 1.4f};
  const RayScene rays(small.makeScene());
  const SamplePoints points = makeSamplePoints(small, {32, 8});
  const PointLinks links = linkPoints(rays, points);
  Signals signals;
  signals.count = 8;
  for (const glm::vec3& at : points.position_m) {
    for (int s = 0; s < 8; ++s) signals.value.push_back(static_cast<float>(product(s, at - 0.96f)));
  }
  // light must outweigh slopes by far to settle it: slopes alone would have the functions flatter
  const SolvedFunctions solved = solveFunctions(points, links, signals, {200, 0.03, 1e-6, 0.1});
  const BlendWeights tent = normalised(points.tent());
  double squares = 0.0, squares_of_tent = 0.0;
  for (size_t i = 0; i < points.count(); ++i) {
    if (points.use[i] == PointUse::test) continue;
    for (int c = 0; c < kCornerCount; ++c) {
      squares += std::pow(double{solved.weights[i][c]} - tent[i][c], 2.0);
      squares_of_tent += std::pow(tent[i][c] - 0.125, 2.0);
    }
  }
  // nine tenths of what tells the tent from a plain mean of all eight
  EXPECT_LT(squares, 0.01 * squares_of_tent);
  EXPECT_LT(solved.loss, 1e-5);
}

TEST(JointSolve, StopsAWallsProbesAtTheWall) {
  const Fixture rooms({3.4f, 1.4f, 1.4f}, true, 32);
  // each room has lights of its own, which differ along it: the other room's probes are of no use
  const Signals signals = rooms.signals(
      16, [](int s, const glm::vec3& at) { return (s < 8) == (at.x < 1.55f) ? 1.0 + 0.3 * product(s % 8, at) : 0.0; });
  const SolvedFunctions solved = solveFunctions(rooms.points, rooms.links, signals, {200, 0.03, 1e-4, 0.1});
  double leak = 0.0, leak_of_tent = 0.0;
  int count = 0;
  const BlendWeights tent = normalised(rooms.points.tent());
  for (size_t i = 0; i < rooms.points.count(); ++i) {
    const float x = rooms.points.position_m[i].x;
    if (rooms.points.use[i] == PointUse::test || x < 1.0f || x > 2.0f) continue;
    ++count;
    for (int c = 0; c < kCornerCount; ++c) {
      const int probe = rooms.points.probe[i][c];
      if (probe < 0 || (rooms.points.probe_position_m[probe].x < 1.55f) == (x < 1.55f)) continue;
      leak += solved.weights[i][c];
      leak_of_tent += tent[i][c];
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_GT(leak_of_tent / count, 0.2);  // a quarter on average, were the wall in the middle
  EXPECT_LT(leak / count, 0.02);
}

TEST(JointSolve, BeatsTheTentOnLightingThatItHasNotSeenAtPointsThatItHasNotSeen) {
  const Fixture rooms({3.4f, 1.4f, 1.4f}, true, 32);
  const auto lighting = [](int shift) {
    return [shift](int s, const glm::vec3& at) {
      const double turn = 2.4 * (s + shift);
      const bool shines_here = (at.x < 1.55f) == (s % 2 == 0);
      return shines_here ? 1.5 + 0.5 * (std::sin(turn) * at.x + std::cos(turn) * at.z + std::sin(3.0 * turn) * at.y) : 0.0;
    };
  };
  const Signals seen = rooms.signals(24, lighting(0)), test = rooms.signals(8, lighting(50));
  const SolvedFunctions solved = solveFunctions(rooms.points, rooms.links, seen, {100, 0.03, 1e-3, 0.1});
  const auto error = [&](const BlendWeights& weights) {
    const std::vector<float> probes = solveProbes(rooms.points, weights, test, pointsOf(rooms.points, {PointUse::fit}));
    return meanSquare(rooms.points, squaredErrors(rooms.points, weights, probes, test), PointUse::test);
  };
  EXPECT_LT(error(solved.weights), 0.25 * error(normalised(rooms.points.tent())));
}

TEST(JointSolve, GivesTheSameBitsAgain) {
  const Fixture box({1.4f, 1.4f, 1.4f}, true, 16);
  const Signals signals = box.signals(9, [](int s, const glm::vec3& at) { return std::sin(s + at.x * at.y) + at.z; });
  const SolvedFunctions a = solveFunctions(box.points, box.links, signals, {15, 0.03, 1e-3, 0.1});
  const SolvedFunctions b = solveFunctions(box.points, box.links, signals, {15, 0.03, 1e-3, 0.1});
  EXPECT_EQ(a.weights, b.weights);
  EXPECT_EQ(a.loss, b.loss);
}

class Gradient : public ::testing::Test {
 protected:
  Gradient() : box_({2.4f, 1.4f, 1.4f}, true, 12) {
    signals_ = box_.signals(5, [](int s, const glm::vec3& at) { return std::sin(1.0 + s + 2.0 * at.x) + at.y * at.z; });
    Random random(3);
    phi_.resize(box_.points.count());
    for (size_t i = 0; i < phi_.size(); ++i) {
      for (int c = 0; c < kCornerCount; ++c) {
        phi_[i][c] = box_.points.probe[i][c] >= 0 ? static_cast<float>(random.uniform(0.2, 1.0)) : 0.0f;
      }
    }
    probes_.resize(box_.points.probe_position_m.size() * signals_.count);
    for (float& value : probes_) value = static_cast<float>(random.uniform(-1.0, 1.0));
  }

  Fixture box_;
  Signals signals_;
  BlendWeights phi_;
  std::vector<float> probes_;
};

TEST_F(Gradient, ByFunctionsIsThatOfFiniteDifferences) {
  const JointProblem problem(box_.points, box_.links, signals_, {0, 0.0, 0.3, 0.2});
  BlendWeights by_phi;
  problem.evaluate(phi_, probes_, &by_phi, nullptr);
  Random random(4);
  const auto count = static_cast<uint32_t>(phi_.size());
  // the value is about 1, summed from floats: differences carry an error of about 1e-8, over the step of .02
  const double step = 0.01, rounding = 1e-6;
  for (int trial = 0; trial < 60; ++trial) {
    const uint32_t i = random.below(count);
    const int c = static_cast<int>(random.below(kCornerCount));
    if (box_.points.probe[i][c] < 0 || box_.points.use[i] == PointUse::test || box_.points.use[i] == PointUse::probe) {
      ASSERT_EQ(by_phi[i][c], 0.0f);
      continue;
    }
    BlendWeights lower = phi_, upper = phi_;
    lower[i][c] -= static_cast<float>(step);
    upper[i][c] += static_cast<float>(step);
    const double difference =
        (problem.evaluate(upper, probes_, nullptr, nullptr) - problem.evaluate(lower, probes_, nullptr, nullptr)) /
        (double{upper[i][c]} - lower[i][c]);
    ASSERT_NEAR(by_phi[i][c], difference, rounding + 0.01 * std::fabs(difference)) << "point " << i << ", corner " << c;
  }
}

TEST_F(Gradient, ByProbesIsThatOfFiniteDifferencesAndVanishesAtTheBestOnes) {
  const JointProblem problem(box_.points, box_.links, signals_, {0, 0.0, 0.3, 0.2});
  std::vector<float> by_probes;
  problem.evaluate(phi_, probes_, nullptr, &by_probes);
  double largest = 0.0;
  for (size_t p = 0; p < probes_.size(); p += 3) {
    std::vector<float> lower = probes_, upper = probes_;
    lower[p] -= 0.1f;  // the value is a square in the probes: any step gives the exact slope
    upper[p] += 0.1f;
    const double difference =
        (problem.evaluate(phi_, upper, nullptr, nullptr) - problem.evaluate(phi_, lower, nullptr, nullptr)) /
        (double{upper[p]} - lower[p]);
    ASSERT_NEAR(by_probes[p], difference, 1e-6 + 1e-3 * std::fabs(difference)) << "probe value " << p;
    largest = std::max(largest, std::fabs(difference));
  }
  problem.evaluate(phi_, problem.bestProbes(phi_), nullptr, &by_probes);
  for (const float slope : by_probes) ASSERT_LT(std::fabs(slope), 1e-4 * largest);
}

}  // namespace
}  // namespace nlg
