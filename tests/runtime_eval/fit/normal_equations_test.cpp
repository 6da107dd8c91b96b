#include "runtime_eval/fit/normal_equations.h"

#include <gtest/gtest.h>

#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/fit/loss/loss_kernel.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/fit/reference_loss.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

const PointSet& stratified() { return stratifiedSupportPoints(); }

// Two factors of 24 + 16 roundings, the sum of 1024 points in 4 or more lanes 256 + 2, strata in double.
constexpr double kEquationRoundings = 2 * (24 + 16) + 256 + 2;

// d representation / d theta at one point. The gradient of one point's squared residual is 2 r times it; with phi one half
// below the output, r is positive and its square the loss.
std::vector<double> derivatives(const NetworkKind& network, double slope, const PointSet& set, int point,
                                const std::vector<double>& theta) {
  const double output = evaluateNetworkReference(network, slope, {set.x[point], set.y[point], set.z[point]}, theta.data());
  const float phi = static_cast<float>(output - 0.5), mask = 1.0f;
  std::vector<double> gradient(network.shape.thetaCount());
  const double square =
      networkLossAndGradientReference(network, slope, set, point, 1, &phi, &mask, theta.data(), gradient.data());
  for (double& value : gradient) value /= 2.0 * std::sqrt(square);
  return gradient;
}

// Sum over valid points of J^T J in double.
std::vector<double> explicitHessian(const NetworkKind& network, double slope, const PointSet& set, const AlignedFloats& mask,
                                    const std::vector<double>& theta) {
  const int count = network.shape.thetaCount();
  std::vector<double> hessian(size_t(count) * count, 0.0);
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (mask[p] == 0.0f) continue;
    const std::vector<double> row = derivatives(network, slope, set, p, theta);
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b < count; ++b) hessian[a * count + b] += row[a] * row[b];
    }
  }
  return hessian;
}

NormalEquations equationsOf(const Representation& representation, const WeightingFunction& function, const Theta& theta) {
  NormalEquationsKernel kernel;
  NormalEquations equations;
  kernel.compute(representation, function, theta.data(), &equations);
  return equations;
}

TEST(NormalEquations, EqualTheExplicitProductOnEveryTarget) {
  // the tent at the border of the support vanishes to float's last bits in both: evaluateReference takes the same tent. A sigmoid's
  // derivative, .25 or less, is off by .1 of the 24 roundings of its sum's magnitude, some tens here: within the bound
  for (const Representation& representation : kNetworkRepresentations) {
    const int theta_count = representation.thetaCount();
    const Theta theta = randomTheta(representation, 21);
    WeightingFunction function = decoded(wallSample(21).view());
    maskKinks(representation, stratified(), theta, 1e-3, &function.mask);
    const std::vector<double> expected =
        explicitHessian(representation.network(), representation.slope, stratified(), function.mask, toDouble(theta));
    const std::vector<double> magnitude =
        explicitHessian(magnitudeNetwork(representation), representation.slope, magnitudes(stratified()), function.mask,
                        magnitudes(representation, theta));
    forEachTarget([&] {
      const NormalEquations got = equationsOf(representation, function, theta);
      for (int row = 0; row < theta_count; ++row) {
        for (int column = 0; column <= row; ++column) {
          const int i = row * theta_count + column;
          ASSERT_NEAR(got.hessian.at(row, column), expected[i], kEquationRoundings * kFloatRounding * magnitude[i])
              << representationName(representation) << ", row " << row << ", column " << column;
        }
      }
    });
  }
}

TEST(NormalEquations, HaveHalfTheGradientOfTheLossKernel) {
  const PointSet absolute_points = magnitudes(stratified());
  for (const Representation& representation : kNetworkRepresentations) {
    for (uint64_t seed = 30; seed < 33; ++seed) {
      const Theta theta = randomTheta(representation, seed);
      const WeightingFunction function = decoded(wallSample(seed).view());
      const AlignedFloats minus_phi = negated(function.phi);
      std::vector<double> magnitude(representation.thetaCount());
      const double sum_magnitude = networkLossAndGradientReference(
          magnitudeNetwork(representation), representation.slope, absolute_points, 0, kSupportPointCount, minus_phi.data(),
          function.mask.data(), magnitudes(representation, theta).data(), magnitude.data());
      forEachTarget([&] {
        std::vector<float> gradient(representation.thetaCount());
        const double sum = networkLossAndGradient(representation, stratified(), 0, kSupportPointCount, function.phi.data(),
                                                  function.mask.data(), theta.data(), gradient.data());
        const NormalEquations got = equationsOf(representation, function, theta);
        // both share the forward pass, kinks included; each has its own roundings
        EXPECT_NEAR(got.square_sum, sum, 2 * kEquationRoundings * kFloatRounding * sum_magnitude) << "seed " << seed;
        for (int k = 0; k < representation.thetaCount(); ++k) {
          ASSERT_NEAR(got.gradient[k], 0.5 * gradient[k], kEquationRoundings * kFloatRounding * magnitude[k])
              << representationName(representation) << ", seed " << seed << ", theta " << k;
        }
      });
    }
  }
}

TEST(NormalEquations, IgnoreMaskedPointsAndWhatTheWorkspaceHeld) {
  const Theta theta = randomTheta({}, 50);
  WeightingFunction function = decoded(wallSample(50).view());
  // one stratum without any valid point: it is skipped, its rows stay in the workspace
  std::fill_n(&function.mask[3 * kStratumPointCount], kStratumPointCount, 0.0f);
  function.valid_count[3] = 0;
  const NormalEquations fresh = equationsOf({}, function, theta);
  NormalEquationsKernel used;
  NormalEquations equations;
  used.compute(Representation::tentMlp(0.3f), decoded(noiseSample(51).view()), randomTheta({}, 51).data(), &equations);
  for (int i = 0; i < kSupportPointCount; ++i) {
    if (function.mask[i] == 0.0f) function.phi[i] = -1e6f;
  }
  const Representation small{RepresentationKind::tent_mlp44};
  used.compute(small, function, randomTheta(small, 52).data(), &equations);
  used.compute({}, function, theta.data(), &equations);
  for (int r = 0; r < ThetaLayout::count; ++r) {
    for (int c = 0; c <= r; ++c) EXPECT_EQ(equations.hessian.at(r, c), fresh.hessian.at(r, c)) << r << ' ' << c;
  }
  EXPECT_EQ(equations.gradient, fresh.gradient);
  EXPECT_EQ(equations.square_sum, fresh.square_sum);
}

}  // namespace
}  // namespace nlg
