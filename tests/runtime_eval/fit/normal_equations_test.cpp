#include "runtime_eval/fit/normal_equations.h"

#include <gtest/gtest.h>

#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/fit/network_loss.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

const PointSet& points() { return stratifiedSupportPoints(); }

// Two factors of 24 + 16 roundings, the sum of 1024 points in 4 or more lanes 256 + 2, strata in double.
constexpr double kRoundings = 2 * (24 + 16) + 256 + 2;

// d representation / d theta at one point. The gradient of one point's squared residual is 2 r times it; with phi one half
// below the output, r is positive and its square the loss.
std::vector<double> derivatives(const Representation& representation, const PointSet& set, int point,
                                const std::vector<double>& theta) {
  const double output = evaluateReference(representation, {set.x[point], set.y[point], set.z[point]}, theta.data());
  const float phi = static_cast<float>(output - 0.5), mask = 1.0f;
  std::vector<double> gradient(ThetaLayout::count);
  const double square =
      networkLossAndGradientReference(representation, set, point, 1, &phi, &mask, theta.data(), gradient.data());
  for (double& value : gradient) value /= 2.0 * std::sqrt(square);
  return gradient;
}

// Sum over valid points of J^T J in double.
std::vector<double> explicitHessian(const Representation& representation, const PointSet& set, const AlignedFloats& mask,
                                    const std::vector<double>& theta) {
  std::vector<double> hessian(ThetaLayout::count * ThetaLayout::count, 0.0);
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (mask[p] == 0.0f) continue;
    const std::vector<double> row = derivatives(representation, set, p, theta);
    for (int a = 0; a < ThetaLayout::count; ++a) {
      for (int b = 0; b < ThetaLayout::count; ++b) hessian[a * ThetaLayout::count + b] += row[a] * row[b];
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
  // the tent at the border of the support vanishes to float's last bits in both: evaluateReference takes the same tent
  for (const Representation& representation : {kBothRepresentations[0], kBothRepresentations[1]}) {
    const Theta theta = randomTheta({}, 21);
    WeightingFunction function = decodeFunction(wallSample(21).view());
    maskKinks(representation, points(), theta, 1e-3, &function.mask);
    const std::vector<double> expected = explicitHessian(representation, points(), function.mask, toDouble(theta));
    const std::vector<double> magnitude = explicitHessian(representation, magnitudes(points()), function.mask, magnitudes(theta));
    forEachTarget([&] {
      const NormalEquations got = equationsOf(representation, function, theta);
      for (int row = 0; row < ThetaLayout::count; ++row) {
        for (int column = 0; column <= row; ++column) {
          const int i = row * ThetaLayout::count + column;
          ASSERT_NEAR(got.hessian.at(row, column), expected[i], kRoundings * kFloatRounding * magnitude[i])
              << representationName(representation) << ", row " << row << ", column " << column;
        }
      }
    });
  }
}

TEST(NormalEquations, HaveHalfTheGradientOfTheLossKernel) {
  const PointSet absolute_points = magnitudes(points());
  for (const Representation& representation : kBothRepresentations) {
    for (uint64_t seed = 30; seed < 33; ++seed) {
      const Theta theta = randomTheta({}, seed);
      const WeightingFunction function = decodeFunction(wallSample(seed).view());
      const AlignedFloats minus_phi = negated(function.phi);
      std::vector<double> magnitude(ThetaLayout::count);
      const double sum_magnitude =
          networkLossAndGradientReference(representation, absolute_points, 0, kSupportPointCount, minus_phi.data(),
                                          function.mask.data(), magnitudes(theta).data(), magnitude.data());
      forEachTarget([&] {
        float gradient[ThetaLayout::count];
        const double sum = networkLossAndGradient(representation, points(), 0, kSupportPointCount, function.phi.data(),
                                                  function.mask.data(), theta.data(), gradient);
        const NormalEquations got = equationsOf(representation, function, theta);
        // both share the forward pass, kinks included; each has its own roundings
        EXPECT_NEAR(got.square_sum, sum, 2 * kRoundings * kFloatRounding * sum_magnitude) << "seed " << seed;
        for (int k = 0; k < ThetaLayout::count; ++k) {
          ASSERT_NEAR(got.gradient[k], 0.5 * gradient[k], kRoundings * kFloatRounding * magnitude[k])
              << representationName(representation) << ", seed " << seed << ", theta " << k;
        }
      });
    }
  }
}

TEST(NormalEquations, ArePositiveSemidefinite) {
  for (const Representation& representation : kBothRepresentations) {
    for (uint64_t seed = 40; seed < 44; ++seed) {
      const NormalEquations got = equationsOf(representation, decodeFunction(noiseSample(seed).view()), randomTheta({}, seed));
      double trace = 0.0;
      for (int i = 0; i < ThetaLayout::count; ++i) {
        trace += got.hessian.at(i, i);
      }
      // Rounding of the sums moves eigenvalues by at most 258 u times the trace of J^T J: Cholesky succeeds once that is added.
      SymmetricBand matrix = got.hessian;
      std::vector<double> vector(ThetaLayout::count, 1.0);
      for (int i = 0; i < ThetaLayout::count; ++i) matrix.at(i, i) += 258 * kFloatRounding * trace;
      EXPECT_TRUE(matrix.solve(vector.data())) << representationName(representation) << ", seed " << seed;
    }
  }
}

TEST(NormalEquations, IgnoreMaskedPointsAndWhatTheWorkspaceHeld) {
  const Theta theta = randomTheta({}, 50);
  WeightingFunction function = decodeFunction(wallSample(50).view());
  // one stratum without any valid point: it is skipped, its rows stay in the workspace
  std::fill_n(&function.mask[3 * kStratumPointCount], kStratumPointCount, 0.0f);
  function.valid_count[3] = 0;
  const NormalEquations fresh = equationsOf({}, function, theta);
  NormalEquationsKernel used;
  NormalEquations equations;
  used.compute(Representation::tentMlp(0.3f), decodeFunction(noiseSample(51).view()), randomTheta({}, 51).data(), &equations);
  for (int i = 0; i < kSupportPointCount; ++i) {
    if (function.mask[i] == 0.0f) function.phi[i] = -1e6f;
  }
  used.compute({}, function, theta.data(), &equations);
  for (int r = 0; r < ThetaLayout::count; ++r) {
    for (int c = 0; c <= r; ++c) EXPECT_EQ(equations.hessian.at(r, c), fresh.hessian.at(r, c)) << r << ' ' << c;
  }
  EXPECT_EQ(equations.gradient, fresh.gradient);
  EXPECT_EQ(equations.square_sum, fresh.square_sum);
}

}  // namespace
}  // namespace nlg
