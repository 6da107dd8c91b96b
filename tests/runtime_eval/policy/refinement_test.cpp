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

}  // namespace
}  // namespace nlg
