#include "runtime_eval/fit/refinement.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

TEST(Refiner, IsNeverInMoreTroubleThanItsStart) {
  Refiner refiner;
  FunctionChecker checker;
  const RefinementOptions options{.rounds = 2, .first_steps = 80};
  for (const Representation& representation : kNetworkRepresentations) {
    for (uint64_t seed = 1; seed < 8; ++seed) {
      const StoredSample sample = seed % 3 == 0 ? noiseSample(seed) : wallSample(seed);
      const Theta start = randomTheta(representation, seed);
      const double before = checker.check(representation, sample.view(), start.data(), options.check).trouble(options.check);
      const RefinementResult result = refiner.refine(representation, sample.view(), start, {}, options);
      EXPECT_LE(result.check.trouble(options.check), before) << "seed " << seed;
      // what it says is what its theta does
      const FunctionCheck again = checker.check(representation, sample.view(), result.theta.data(), options.check);
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
  const RefinementResult result = refiner.refine(Representation::tentMlp(), sample.view(), tent_theta, {}, {});
  EXPECT_EQ(result.theta, tent_theta);
  EXPECT_EQ(result.steps, 0);
}

TEST(Refiner, BringsMostWallsUnderTheThreshold) {
  Refiner refiner;
  const RefinementOptions options{.rounds = 2};
  int passed = 0;
  for (uint64_t seed = 20; seed < 30; ++seed) {
    const RefinementResult result =
        refiner.refine(Representation::tentMlp(), wallSample(seed).view(), randomTheta({}, seed), {}, options);
    passed += result.check.passes(options.check);
  }
  // random starts: some end in poor minima
  EXPECT_GE(passed, 6);
}

TEST(Refiner, SurvivesAStartThatIsNotFinite) {
  Refiner refiner;
  const StoredSample sample = wallSample(9);
  const RefinementResult result = refiner.refine({}, sample.view(), Theta(ThetaLayout::count, NAN), {}, {});
  EXPECT_FALSE(result.check.passes({}));
  EXPECT_EQ(result.stop, FitStop::not_finite);
}

TEST(Refiner, GoesBackToTheta0WhenTheStartIsBroken) {
  Refiner refiner;
  Theta theta0(ThetaLayout::count, 0.0f);
  theta0[ThetaLayout::b3] = 0.5f;
  const StoredSample sample = wallSample(9);
  const RefinementOptions options{.rounds = 1, .first_steps = 50};
  const RefinementResult result =
      refiner.refine(Representation::tentMlp(), sample.view(), Theta(ThetaLayout::count, NAN), theta0, options);
  FunctionChecker checker;
  EXPECT_LE(result.check.rmse, checker.check(Representation::tentMlp(), sample.view(), theta0.data(), options.check).rmse);
  for (const float value : result.theta) ASSERT_TRUE(std::isfinite(value));
}

TEST(WorstFirst, OrdersFailuresByTroubleThenIndex) {
  std::vector<FunctionCheck> checks(6);
  checks[0].rmse = 0.03;
  checks[1].rmse = 0.001;
  checks[2].leak_share = 0.7;  // trouble 1.7, more than an RMSE of one and a half times what is allowed
  checks[3].rmse = 0.03;
  checks[4].rmse = NAN;
  checks[5].rmse = 0.02;  // exactly what is allowed
  EXPECT_EQ(worstFirst(checks, {}), (std::vector<uint32_t>{4, 2, 0, 3}));
}

}  // namespace
}  // namespace nlg
