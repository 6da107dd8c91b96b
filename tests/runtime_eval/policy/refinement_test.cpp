#include "runtime_eval/policy/refinement.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

TEST(Refiner, IsNeverInMoreTroubleThanItsStart) {
  Refiner refiner;
  FunctionChecker checker;
  CheckOptions check;
  const RefinementOptions options{.refine_rounds = 2, .refine_first_steps = 80};
  for (const Representation& representation : kNetworkRepresentations) {
    for (uint64_t seed = 1; seed < 8; ++seed) {
      const StoredSample sample = seed % 3 == 0 ? noiseSample(seed) : wallSample(seed);
      const Theta start = randomTheta(representation, seed);
      const double before = checker.check(representation, sample.view(), start.data(), check).trouble(check);
      const RefinementResult result = refiner.refine(representation, sample.view(), start, {}, check, options);
      EXPECT_LE(result.check.trouble(check), before) << "seed " << seed;
      // what it says is what its theta does
      const FunctionCheck again = checker.check(representation, sample.view(), result.theta.data(), check);
      EXPECT_EQ(again.rmse, result.check.rmse) << "seed " << seed;
      EXPECT_EQ(again.leak_share, result.check.leak_share) << "seed " << seed;
    }
  }
}

TEST(Refiner, LeavesAloneWhatPasses) {
  Theta tent_theta(ThetaLayout::count, 0.0f);
  tent_theta[ThetaLayout::b3] = 1.0f;
  StoredSample sample;
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{255});
  for (int p = 0; p < kSupportPointCount; ++p) {
    sample.phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
  }
  Refiner refiner;
  const RefinementResult result = refiner.refine(Representation::tentMlp(), sample.view(), tent_theta, {}, {}, {});
  EXPECT_EQ(result.theta, tent_theta);
  EXPECT_EQ(result.steps, 0);
}

TEST(Refiner, BringsMostWallsUnderTheThreshold) {
  Refiner refiner;
  CheckOptions check;
  const RefinementOptions options{.refine_rounds = 2};
  int passed = 0;
  for (uint64_t seed = 20; seed < 30; ++seed) {
    const RefinementResult result =
        refiner.refine(Representation::tentMlp(), wallSample(seed).view(), randomTheta({}, seed), {}, check, options);
    passed += result.check.passes(check);
  }
  // random starts: some end in poor minima
  EXPECT_GE(passed, 6);
}

// The tent, and nothing in a corner of the support behind a wall: less than 200 of 8192 points.
TEST(Refiner, ClosesALeakAtFewPointsThatThePlainFitLeaves) {
  StoredSample sample;
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{255});
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = supportPattern().points[p];
    sample.phi[p] = point[0] > 0.75f && point[1] > 0.5f ? 0 : static_cast<uint8_t>(std::lround(255.0f * tent(point)));
  }
  const Representation representation = Representation::tentMlp();
  FunctionChecker checker;
  const CheckOptions check;
  Theta start = randomTheta(representation, 3);
  const WeightingFunction plain = decoded(sample.view());
  start = fitAdam(representation, plain, start, randomStartAdam(representation, 100)).theta;
  const FunctionCheck before = checker.check(representation, sample.view(), start.data(), check);
  ASSERT_LT(before.rmse, check.tau_rmse);
  ASSERT_FALSE(before.passes(check));
  const RefinementResult result = Refiner().refine(representation, sample.view(), start, {}, check, {});
  EXPECT_TRUE(result.check.passes(check)) << result.check.blend_rmse;
}

TEST(Refiner, GoesOnFromRandomStartsWhenTheStartIsBroken) {
  Refiner refiner;
  const StoredSample sample = wallSample(9);
  CheckOptions check;
  const RefinementOptions options{.refine_rounds = 1, .refine_first_steps = 50};
  const RefinementResult result =
      refiner.refine(Representation::tentMlp(), sample.view(), Theta(ThetaLayout::count, NAN), {}, check, options);
  for (const float value : result.theta) ASSERT_TRUE(std::isfinite(value));
  EXPECT_LT(result.check.rmse, 1.0);
}

TEST(Refiner, TriesOtherStartsBeforeItsLastRound) {
  Refiner refiner;
  // nothing passes, so that every round runs: 20 steps, 20 from each other start, 40
  CheckOptions check;
  RefinementOptions options{.refine_rounds = 2, .refine_first_steps = 20, .refine_growth = 2};
  check.tau_rmse = 1e-6;
  const StoredSample sample = wallSample(9);
  const Representation tent_mlp = Representation::tentMlp();
  const Theta start = randomTheta(tent_mlp, 50), theta0 = randomTheta(tent_mlp, 51);
  EXPECT_EQ(refiner.refine(tent_mlp, sample.view(), start, theta0, check, options).steps, 20 + 4 * 20 + 40);
  EXPECT_EQ(refiner.refine(tent_mlp, sample.view(), start, {}, check, options).steps, 20 + 3 * 20 + 40);
  // a single round comes first
  options.refine_rounds = 1;
  EXPECT_EQ(refiner.refine(tent_mlp, sample.view(), start, theta0, check, options).steps, 20 + 4 * 20);
  options.refine_rounds = 0;
  EXPECT_EQ(refiner.refine(tent_mlp, sample.view(), start, theta0, check, options).steps, 0);
}

TEST(Refiner, GoesBackToTheta0WhenTheStartIsBroken) {
  Refiner refiner;
  Theta theta0(ThetaLayout::count, 0.0f);
  theta0[ThetaLayout::b3] = 0.5f;
  const StoredSample sample = wallSample(9);
  CheckOptions check;
  const RefinementOptions options{.refine_rounds = 1, .refine_first_steps = 50};
  const RefinementResult result =
      refiner.refine(Representation::tentMlp(), sample.view(), Theta(ThetaLayout::count, NAN), theta0, check, options);
  FunctionChecker checker;
  EXPECT_LE(result.check.rmse, checker.check(Representation::tentMlp(), sample.view(), theta0.data(), check).rmse);
  for (const float value : result.theta) ASSERT_TRUE(std::isfinite(value));
}

// All sigmoids are shut there, and no step of a fit leads back.
TEST(Refiner, BeginsAnewWhereACodeIsFarOut) {
  Refiner refiner;
  FunctionChecker checker;
  const Representation code = Representation::code(sampleDictionary(9, 16, 1));
  const StoredSample sample = wallSample(9);
  Theta start(16, 0.0f);
  start[0] = 1e30f;
  const double before = checker.check(code, sample.view(), start.data(), {}).blend_rmse;
  const RefinementResult result = refiner.refine(code, sample.view(), start, {}, {}, {.refine_rounds = 1});
  EXPECT_LT(result.check.blend_rmse, 0.9 * before);
  EXPECT_LT(std::abs(result.theta[0]), 1e3f);
}

TEST(WorstFirst, OrdersFailuresByTroubleThenIndex) {
  std::vector<FunctionCheck> checks(6);
  checks[0].rmse = 0.03;
  checks[1].rmse = 0.001;
  checks[2].blend_rmse = 0.051;  // trouble 1.7, more than an RMSE of one and a half times what is allowed
  checks[3].rmse = 0.03;
  checks[4].rmse = NAN;
  checks[5].rmse = 0.02;  // exactly what is allowed
  EXPECT_EQ(worstFirst(checks, {}), (std::vector<uint32_t>{4, 2, 0, 3}));
}

}  // namespace
}  // namespace nlg
