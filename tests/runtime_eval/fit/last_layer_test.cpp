#include "runtime_eval/fit/last_layer.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/fit/reference_loss.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

TEST(LastLayer, LeavesNoGradientInItself) {
  // At the least-squares solution the gradient by w3 and b3 vanishes. What is left is the rounding of theta to float and of the
  // products' sums: 2^-20 of the magnitudes that cancel is generous for 256 roundings and a condition of 1e9 damped by the ridge.
  forEachTarget([] {
    for (const Representation& representation : kBothRepresentations) {
      for (uint64_t seed = 1; seed < 6; ++seed) {
        // with every dark point counting once, and 64 times: the solution is that of weighed least squares
        const WeightingFunction function = decoded(wallSample(seed).view(), stratumOrder(), {seed % 2 == 0 ? 64.0 : 1.0, 1.0});
        Theta theta = randomTheta(representation, seed);
        const double before = functionRmse(representation, function, theta.data());
        ASSERT_TRUE(solveLastLayer(representation, function, theta.data()));
        EXPECT_LT(functionRmse(representation, function, theta.data()), before) << "seed " << seed;
        std::vector<double> gradient(ThetaLayout::count), magnitude(ThetaLayout::count);
        networkLossAndGradientReference(representation, stratifiedSupportPoints(), 0, kSupportPointCount, function.phi.data(),
                                        function.mask.data(), toDouble(theta).data(), gradient.data());
        const AlignedFloats minus_phi = negated(function.phi);
        networkLossAndGradientReference(representation, magnitudes(stratifiedSupportPoints()), 0, kSupportPointCount,
                                        minus_phi.data(), function.mask.data(), magnitudes(theta).data(), magnitude.data());
        for (int i = ThetaLayout::w3; i <= ThetaLayout::b3; ++i) {
          EXPECT_NEAR(gradient[i], 0.0, 0x1p-20 * magnitude[i])
              << representationName(representation) << ' ' << i << ", seed " << seed;
        }
      }
    }
  });
}

TEST(LastLayer, SurvivesDeadUnitsAndRefusesBrokenTheta) {
  const WeightingFunction function = decoded(wallSample(8).view());
  // every unit of the second layer the same: eight equal rows
  Theta equal(ThetaLayout::count, 0.0f);
  for (int j = 0; j < kHiddenCount; ++j) equal[ThetaLayout::b2 + j] = 1.0f;
  ASSERT_TRUE(solveLastLayer({}, function, equal.data()));
  for (const float value : equal) ASSERT_TRUE(std::isfinite(value));
  Theta broken(ThetaLayout::count, NAN);
  EXPECT_FALSE(solveLastLayer({}, function, broken.data()));
  // no valid point: no equations
  WeightingFunction empty = function;
  std::fill(empty.mask.begin(), empty.mask.end(), 0.0f);
  Theta theta = randomTheta({}, 8);
  EXPECT_FALSE(solveLastLayer({}, empty, theta.data()));
  EXPECT_EQ(theta, randomTheta({}, 8));
}

}  // namespace
}  // namespace nlg
