#include "runtime_eval/evaluator/evaluate.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

constexpr int kRaggedCounts[] = {1, 2, 7, 8, 9, 31, 95, 96, 97, 257};

// A value passes 3 + 9 + 9 fused multiply-adds, two slopes and the tent; products of the terms with 1 + u each.
constexpr double kRoundings = 24;

TEST(Evaluate, EqualsTheReferenceOnEveryTarget) {
  forEachTarget([] {
    for (const Representation& representation : kNetworkRepresentations) {
      const NetworkKind magnitude = magnitudeNetwork(representation);
      for (const int count : kRaggedCounts) {
        const Theta theta = randomTheta(representation, static_cast<uint64_t>(count));
        const std::vector<double> exact = toDouble(theta), absolute = magnitudes(representation, theta);
        const std::vector<LocalPoint> list = testPoints(count);
        const PointSet points = makePointSet(list);
        AlignedFloats values(points.padded_count);
        evaluate(representation, points, theta.data(), values.data());
        for (int i = 0; i < count; ++i) {
          const double bound = kRoundings * kFloatRounding *
                               evaluateNetworkReference(magnitude, representation.slope, magnitudes(list[i]), absolute.data());
          ASSERT_NEAR(values[i], evaluateReference(representation, list[i], exact.data()), bound)
              << representationName(representation) << ", point " << i << " of " << count;
        }
      }
    }
  });
}

TEST(EvaluatePoint, EqualsTheReference) {
  for (const Representation& representation : kNetworkRepresentations) {
    const Theta theta = randomTheta(representation, 31);
    const std::vector<double> exact = toDouble(theta), absolute = magnitudes(representation, theta);
    for (const LocalPoint& point : testPoints(300)) {
      const double bound =
          kRoundings * kFloatRounding *
          evaluateNetworkReference(magnitudeNetwork(representation), representation.slope, magnitudes(point), absolute.data());
      ASSERT_NEAR(evaluatePoint(representation, point, theta.data()), evaluateReference(representation, point, exact.data()),
                  bound)
          << representationName(representation) << " at " << point[0] << ' ' << point[1] << ' ' << point[2];
    }
  }
}

TEST(Evaluate, WritesNothingBehindThePaddedCount) {
  forEachTarget([] {
    const PointSet points = makePointSet(testPoints(17));
    AlignedFloats values(points.padded_count + 16, 7.0f);
    evaluate({}, points, randomTheta({}, 1).data(), values.data());
    for (int i = points.padded_count; i < points.padded_count + 16; ++i) ASSERT_EQ(values[i], 7.0f) << "at " << i;
  });
}

TEST(EvaluateReference, FollowsASmallNetworkWrittenOutByHand) {
  const Representation four{RepresentationKind::tent_mlp4, 0.25f};
  ASSERT_EQ(four.thetaCount(), 21);
  std::vector<double> theta(21, 0.0);
  theta[3 * 2 + 1] = 2.0;  // unit 2: 2 y
  theta[12 + 2] = 0.5;     //         + .5
  theta[16 + 2] = -3.0;    // output: -3 * that
  theta[20] = 1.0;         //         + 1
  const LocalPoint point{0.5f, 0.5f, 0.0f};
  EXPECT_DOUBLE_EQ(evaluateReference(four, point, theta.data()), 0.25 / (1.0 + std::exp(3.5)));
  const Representation four_four{RepresentationKind::tent_mlp44, 0.25f};
  ASSERT_EQ(four_four.thetaCount(), 41);
  theta.assign(41, 0.0);
  theta[3 * 3 + 0] = -4.0;      // unit 3 of layer 1: -4 x, below zero
  theta[16 + 4 * 1 + 3] = 2.0;  // unit 1 of layer 2: 2 * that
  theta[32 + 1] = 0.75;         //                    + .75
  theta[36 + 1] = 2.0;          // output: 2 * that
  theta[40] = -1.0;             //         - 1
  EXPECT_DOUBLE_EQ(evaluateReference(four_four, point, theta.data()), 0.25 / (1.0 + std::exp(1.0 - 2.0 * 0.25 * -0.25)));
}

}  // namespace
}  // namespace nlg
