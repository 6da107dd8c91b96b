#include "runtime_eval/policy/theta_rounding.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/last_layer.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

const Representation kRounded[] = {Representation::mlp(),
                                   Representation::tentMlp(),
                                   {RepresentationKind::tent_mlp44, 0.01f},
                                   {RepresentationKind::tent_mlp4, 0.01f}};

Theta fittedTheta(const Representation& representation, const WeightingFunction& function, uint64_t seed) {
  return fitAdam(representation, function, randomTheta(representation, seed), randomStartAdam(representation, 600)).theta;
}

// Each number stands within half a step of where it is best given the ones before it, all that follow being free: solved here for
// every number from the equations themselves.
TEST(CompensatedRounding, PutsEveryNumberNextToItsBestGivenTheOnesBefore) {
  for (const Representation& representation : kRounded) {
    const WeightingFunction function = decoded(wallSample(3).view(), pointOrder(representation));
    const Theta fitted = fittedTheta(representation, function, 3);
    const Compensation compensation{{120, 120}, 0.03, 2};
    Theta rounded = fitted, scaled = fitted;
    ASSERT_TRUE(CompensatedRounding().round(representation, function, compensation, rounded.data()));
    scaleHiddenLayers(representation, scaled.data(), compensation.most);
    NormalEquations equations;
    NormalEquationsKernel().compute(representation, function, scaled.data(), &equations, 2000, compensation.first_batch);
    const int D = representation.thetaCount(), hidden = representation.shape().w3();
    const float step = stepOf(representation.shape());
    const auto entry = [&](int i, int j) { return equations.hessian.at(std::max(i, j), std::min(i, j)); };
    double mean = 0.0;
    for (int i = 0; i < D; ++i) mean += entry(i, i) / D;
    for (int i = 0; i < D; ++i) {
      SymmetricBand rest(D - i, D - i - 1);
      std::vector<double> best(D - i, 0.0);
      for (int a = i; a < D; ++a) {
        for (int b = i; b <= a; ++b) rest.at(a - i, b - i) = entry(a, b) + (a == b ? 0.03 * entry(a, a) + 1e-9 * mean : 0.0);
        for (int j = 0; j < i; ++j) best[a - i] -= entry(a, j) * (static_cast<double>(rounded[j]) - scaled[j]);
      }
      ASSERT_TRUE(rest.solve(best.data()));
      const double target = scaled[i] + best[0];
      if (i >= hidden) {
        EXPECT_NEAR(rounded[i], target, 1e-4 * (1.0 + std::fabs(target))) << representationName(representation) << ' ' << i;
        continue;
      }
      EXPECT_EQ(rounded[i], step * std::nearbyint(rounded[i] / step));
      EXPECT_LE(std::fabs(rounded[i]), kMostThetaSteps * step);
      if (std::fabs(target) < kMostThetaSteps * step) {
        EXPECT_NEAR(rounded[i], target, 0.501 * step) << representationName(representation) << ' ' << i;
      }
    }
  }
}

TEST(CompensatedRounding, LosesLessThanRoundingEachNumberForItself) {
  CompensatedRounding compensated;
  double alone_sum = 0.0, together_sum = 0.0;
  const Representation representation = Representation::mlp();
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const WeightingFunction function = decoded(wallSample(seed).view());
    Theta alone = fittedTheta(representation, function, seed), together = alone;
    solveLastLayer(representation, function, alone.data());
    const double fitted = functionRmse(representation, function, alone.data());
    roundHiddenLayers(representation, alone.data());
    ASSERT_TRUE(compensated.round(representation, function, {}, together.data()));
    for (Theta* theta : {&alone, &together}) ASSERT_TRUE(solveLastLayer(representation, function, theta->data()));
    alone_sum += functionRmse(representation, function, alone.data()) - fitted;
    together_sum += functionRmse(representation, function, together.data()) - fitted;
  }
  EXPECT_GT(alone_sum, 0.0);
  EXPECT_LT(together_sum, 0.7 * alone_sum);
}

}  // namespace
}  // namespace nlg
