#include "runtime_eval/policy/theta_rounding.h"

#include <gtest/gtest.h>

#include "runtime_eval/evaluator/theta_form.h"
#include "tests/runtime_eval/fit/code_functions.h"

namespace nlg {
namespace {

struct Fitted {
  StoredSample sample;
  RoundedTheta present;  // not rounded
};

class CodeRoundingTest : public testing::Test {
 protected:
  // code of 9³ nodes whose numbers count in steps of coarse times those of sampleDictionary
  explicit CodeRoundingTest(int coarse = 0) {
    DictionaryData data = sampleDictionaryData(9, 48, 1);
    for (int k = 0; k < 48; ++k) {
      data.exponents[k] = static_cast<int8_t>(data.exponents[k] + coarse);
      data.deviations[k] = std::ldexp(data.deviations[k], -coarse);
    }
    EXPECT_EQ(whatIsWrong(data), "");
    code_ = Representation::code(std::make_shared<const Dictionary>(data));
    check_.dark_weight = 64.0;
  }

  Fitted fit(StoredSample sample) {
    Fitted fitted{std::move(sample), {}};
    fitted.present.theta.assign(48, 0.0f);
    const WeightingFunction function = decoded(fitted.sample.view(), pointOrder(code_), check_.loss());
    CodeFit().iterate(code_, function, {.iterations = 30}, 48, fitted.present.theta.data());
    fitted.present.check = checkOf(fitted, fitted.present.theta);
    return fitted;
  }
  FunctionCheck checkOf(const Fitted& fitted, const Theta& theta) {
    return checker_.check(code_, fitted.sample.view(), theta.data(), check_);
  }
  RoundedTheta round(const Fitted& fitted, const CodeOptions& options) {
    return CodeRounding(options).round(code_, fitted.sample.view(), fitted.present, check_);
  }
  static int lengthOf(const RoundedTheta& rounded) { return codeLength(48, rounded.theta.data()); }

  Representation code_;
  CheckOptions check_;
  FunctionChecker checker_;
};

class CoarseCodeRoundingTest : public CodeRoundingTest {
 protected:
  CoarseCodeRoundingTest() : CodeRoundingTest(4) {}
};

CodeOptions optionsOf(double flat_ratio, double enough_rmse) {
  CodeOptions options;
  options.code_flat_ratio = flat_ratio;
  options.code_enough_rmse = enough_rmse;
  return options;
}

TEST_F(CodeRoundingTest, GivesBytesAndWhatTheCheckFindsOfThem) {
  for (uint64_t seed = 1; seed < 13; ++seed) {
    const Fitted fitted = fit(seed % 4 == 0 ? noiseSample(seed) : wallSample(seed));
    for (const CodeOptions& options : {CodeOptions{}, optionsOf(1.0, 0.0), optionsOf(2.0, 0.0)}) {
      const RoundedTheta rounded = round(fitted, options);
      Theta again = rounded.theta;
      ASSERT_TRUE(roundTheta(code_, ThetaPrecision::int8, again.data()));
      EXPECT_EQ(again, rounded.theta) << seed;
      const FunctionCheck check = checkOf(fitted, rounded.theta);
      EXPECT_EQ(rounded.check.rmse, check.rmse) << seed;
      EXPECT_EQ(rounded.check.leak_share, check.leak_share) << seed;
      EXPECT_EQ(rounded.check.valid_count, check.valid_count) << seed;
    }
  }
}

TEST_F(CodeRoundingTest, KeepsWhatPassesTheCheck) {
  int shorter = 0, passing = 0;
  for (uint64_t seed = 1; seed < 9; ++seed) {
    const Fitted fitted = fit(fallingSample(code_.dictionary, seed));
    // an error that a short code exceeds; leaks are allowed
    CheckOptions tight = check_;
    tight.tau_blend = 1.0;
    tight.tau_rmse = 1.3 * fitted.present.check.rmse;
    ASSERT_TRUE(fitted.present.check.passes(tight));
    const RoundedTheta loose = CodeRounding(optionsOf(1e6, 0.0)).round(code_, fitted.sample.view(), fitted.present, tight);
    EXPECT_TRUE(loose.check.passes(tight)) << "seed " << seed;
    passing += lengthOf(loose) > 8;
    shorter += lengthOf(loose) < 48;
  }
  // else the check would have chosen nothing
  EXPECT_GT(passing, 0);
  EXPECT_GT(shorter, 0);
}

// In steps 16 times as coarse, rounding is what is wrong about a code.
TEST_F(CoarseCodeRoundingTest, MakesUpForWhatWasRounded) {
  double apart = 0.0, together = 0.0, before = 0.0;
  for (uint64_t seed = 1; seed < 17; ++seed) {
    const Fitted fitted = fit(wallSample(seed));
    Theta plain = fitted.present.theta;
    ASSERT_TRUE(roundTheta(code_, ThetaPrecision::int8, plain.data()));
    apart += checkOf(fitted, plain).blend_rmse;
    together += round(fitted, optionsOf(1.0, 0.0)).check.blend_rmse;
    before += fitted.present.check.blend_rmse;
  }
  EXPECT_GT(apart, 1.05 * before) << "there is something to make up for";
  EXPECT_LT(together - before, 0.5 * (apart - before));
}

// What a fit would refuse must not become bytes.
TEST_F(CodeRoundingTest, SaysOfACodeThatIsNotFiniteThatItFails) {
  Fitted fitted = fit(wallSample(3));
  fitted.present.theta[5] = NAN;
  fitted.present.check = checkOf(fitted, fitted.present.theta);
  EXPECT_FALSE(round(fitted, {}).check.passes(check_));
}

}  // namespace
}  // namespace nlg
