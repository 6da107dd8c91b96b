
#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

// From the definitions, in double.
FunctionCheck expectedCheck(const Representation& representation, const StoredSample& sample, const Theta& theta,
                            const CheckOptions& options) {
  const std::vector<double> exact = toDouble(theta);
  FunctionCheck check;
  double square_sum = 0.0, loss = 0.0, leak_sum = 0.0;
  int over = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (!sample.valid(p)) continue;
    const double value = evaluateReference(representation, supportPattern().points[p], exact.data());
    const double residual = value - sample.phi[p] / 255.0, tent_here = tent(supportPattern().points[p]);
    square_sum += residual * residual;
    ++check.valid_count;
    if (sample.phi[p] != 0) {
      const double sum = sample.blend_sum.empty() ? 1.0 : std::clamp(sample.blend_sum[p] / 255.0, options.blend_floor, 1.0);
      loss += residual * residual / (sum * sum);
      continue;
    }
    loss += residual * residual * (tent_here > 0.5 / 255.0 ? options.dark_weight : 1.0);
    ++check.zero_count;
    leak_sum += std::fabs(value);
    over += std::fabs(value) > options.tau_leak * tent_here + 0.5 / 255.0;
  }
  check.rmse = std::sqrt(square_sum / check.valid_count);
  check.blend_rmse = std::sqrt(loss / check.valid_count);
  check.leak_mean = leak_sum / check.zero_count;
  check.leak_share = static_cast<double>(over) / check.zero_count;
  return check;
}

TEST(FunctionCheck, EqualsItsDefinitionOnEveryTarget) {
  uint64_t seed = 0;
  for (const Representation& representation : sampleRepresentations()) {
    SCOPED_TRACE(representationName(representation));
    // kinds of functions in turn: the reference of a code takes long
    const StoredSample sample = ++seed % 3 == 0 ? noiseSample(seed) : seed % 3 == 1 ? crowdedSample(seed) : wallSample(seed);
    const Theta theta = randomTheta(representation, seed);
    const FunctionCheck expected = expectedCheck(representation, sample, theta, {});
    forEachTarget([&] {
      FunctionChecker checker;
      const FunctionCheck got = checker.check(representation, sample.view(), theta.data(), {});
      EXPECT_EQ(got.valid_count, expected.valid_count);
      EXPECT_EQ(got.zero_count, expected.zero_count);
      // values of a few units, each off by some hundred roundings; sums of 1024 floats
      EXPECT_NEAR(got.rmse, expected.rmse, 2e-4 * expected.rmse);
      EXPECT_NEAR(got.blend_rmse, expected.blend_rmse, 2e-4 * expected.blend_rmse);
      EXPECT_NEAR(got.leak_mean, expected.leak_mean, 2e-4 * expected.leak_mean);
      // a value within rounding of tau may fall on either side
      EXPECT_NEAR(got.leak_share, expected.leak_share, 2.5 / expected.zero_count);
    });
  }
}

TEST(FunctionCheck, HasTheErrorThatFitsMinimise) {
  for (const Representation& representation : kNetworkRepresentations) {
    const StoredSample sample = crowdedSample(5);
    const Theta theta = randomTheta(representation, 5);
    FunctionChecker checker;
    for (const LossOptions& loss : {kUnweighed, LossOptions{64.0, 1.0}, LossOptions{64.0, 0.2}}) {
      CheckOptions options;
      options.dark_weight = loss.dark_weight, options.blend_floor = loss.blend_floor;
      const double fitted = functionRmse(representation, decoded(sample.view(), pointOrder(representation), loss), theta.data());
      const FunctionCheck check = checker.check(representation, sample.view(), theta.data(), options);
      EXPECT_NEAR(check.blend_rmse, fitted, 1e-5 * fitted) << loss.dark_weight << ' ' << loss.blend_floor;
      if (loss.dark_weight == 1.0) {
        EXPECT_NEAR(check.blend_rmse, check.rmse, 1e-6 * check.rmse);
      } else {
        EXPECT_GT(check.blend_rmse, check.rmse);
      }
    }
  }
}

// A slab behind a wall far from the probe: what comes through is nothing to the RMSE, and all the light that is there.
TEST(FunctionCheck, WeighsALeakAtFewPointsOfLowTent) {
  Theta bare(ThetaLayout::count, 0.0f);
  bare[ThetaLayout::b3] = 1.0f;
  FunctionChecker checker;
  const CheckOptions options;
  StoredSample sample;
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{255});
  int dark = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = supportPattern().points[p];
    sample.phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(point)));
    if (point[0] > 0.85f && point[1] > 0.5f && sample.phi[p] > 0) sample.phi[p] = 0, ++dark;
  }
  ASSERT_GT(dark, 20);
  ASSERT_LT(dark, 200);
  const FunctionCheck of_theta = checker.check(Representation::tentMlp(), sample.view(), bare.data(), options);
  EXPECT_LT(of_theta.rmse, options.tau_rmse / 4);
  // nearly all of the error is at dark points; the rest is the rounding of bytes, at most half a step
  EXPECT_GT(of_theta.blend_rmse,
            0.9 * std::sqrt(options.dark_weight) * std::sqrt(of_theta.rmse * of_theta.rmse - 0.25 / (255.0 * 255.0)));
  EXPECT_EQ(checker.checkBareTent(sample.view(), options).blend_rmse, of_theta.blend_rmse);
  // a share that the check allows
  Theta tenth = bare;
  tenth[ThetaLayout::b3] = 0.09f;
  EXPECT_EQ(checker.check(Representation::tentMlp(), sample.view(), tenth.data(), options).leak_share, 0.0);
}

TEST(FunctionCheck, PassesAPerfectThetaAndFailsLeaksAlone) {
  // the constant .15: on a function of .15 leaks at one in 512 points are small in RMSE, and 64 times as much in the loss
  Theta theta(ThetaLayout::count, 0.0f);
  theta[ThetaLayout::b3] = 0.15f;
  StoredSample sample;
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{255});
  std::fill(sample.phi.begin(), sample.phi.end(), uint8_t{38});
  FunctionChecker checker;
  const CheckOptions options;
  EXPECT_TRUE(checker.check({}, sample.view(), theta.data(), options).passes(options));
  for (int p = 0; p < kSupportPointCount; p += 512) sample.phi[p] = 0;
  const FunctionCheck leaking = checker.check({}, sample.view(), theta.data(), options);
  EXPECT_LT(leaking.rmse, options.tau_rmse);
  EXPECT_EQ(leaking.leak_share, 1.0);
  EXPECT_FALSE(leaking.passes(options));
  EXPECT_DOUBLE_EQ(leaking.trouble(options), leaking.blend_rmse / options.tau_blend);
}

TEST(FunctionCheck, FailsAnInfiniteThetaWhoseValuesAreFinite) {
  // a sigmoid of +-Inf is 0 or 1
  FunctionChecker checker;
  const StoredSample sample = wallSample(7);
  const Representation network{RepresentationKind::tent_mlp4, 0.01f};
  for (const float bad : {INFINITY, -INFINITY}) {
    Theta theta = randomTheta(network, 7);
    theta[network.shape().w1()] = bad;
    const FunctionCheck check = checker.check(network, sample.view(), theta.data(), {});
    EXPECT_FALSE(std::isfinite(check.rmse)) << bad;
    EXPECT_FALSE(check.passes({})) << bad;
  }
}

TEST(FunctionCheck, TakesAnErrorThatIsNoNumberForTheLargest) {
  // finite theta with values of +Inf - Inf, which are no numbers
  FunctionChecker checker;
  const StoredSample sample = wallSample(7);
  const Representation network = Representation::mlp();
  Theta theta = randomTheta(network, 7);
  const NetworkShape& shape = network.shape();
  std::fill(theta.begin(), theta.begin() + shape.b3(), 3e38f);
  for (int u = 0; u < shape.last(); u += 2) theta[shape.w3() + u] = -3e38f;
  const FunctionCheck check = checker.check(network, sample.view(), theta.data(), {});
  EXPECT_EQ(check.rmse, INFINITY);
  EXPECT_EQ(check.leak_mean, INFINITY);
  EXPECT_FALSE(check.passes({}));
}

}  // namespace
}  // namespace nlg
