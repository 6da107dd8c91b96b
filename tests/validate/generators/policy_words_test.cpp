// Words and populations over a small set of two scenes, through a generator of random numbers.

#include <gtest/gtest.h>

#include "runtime_eval/evaluator/theta_form.h"
#include "tests/runtime_eval/sample_generator.h"
#include "validate/generators/best_known.h"
#include "validate/generators/policy_words.h"
#include "validate/generators/summary_json.h"

namespace nlg {
namespace {

constexpr int kTents = 3, kWalls = 9, kCount = kTents + kWalls, kWordTestPoints = 64;

// Bare tents first, then functions cut by walls; scenes in turn. What has weight is seen.
FunctionSet smallSet() {
  FunctionSet set;
  set.point_count = kSupportPointCount;
  set.test_point_count = kWordTestPoints;
  set.scene_ids = {"a", "b"};
  for (int i = 0; i < kCount; ++i) {
    const StoredSample sample = i < kTents ? tentSample() : wallSample(static_cast<uint64_t>(i));
    set.scene_idx.push_back(static_cast<uint32_t>(i % 2));
    set.phi.insert(set.phi.end(), sample.phi.begin(), sample.phi.end());
    set.validity.insert(set.validity.end(), sample.validity.begin(), sample.validity.end());
    for (int byte = 0; byte < kValidityByteCount; ++byte) {
      uint8_t seen = 0;
      for (int bit = 0; bit < 8; ++bit) seen = static_cast<uint8_t>(seen | (sample.phi[8 * byte + bit] > 0) << bit);
      set.seen.push_back(seen);
    }
    // walls: some places are seen by this probe alone, others by all
    for (int p = 0; p < kSupportPointCount; ++p)
      set.blend_sum.push_back(static_cast<uint8_t>(i < kTents ? 255 : 32 * (p % 8) + 31));
    set.phi_test.insert(set.phi_test.end(), kWordTestPoints, 128);
    set.validity_test.insert(set.validity_test.end(), kWordTestPoints / 8, 255);
    set.seen_test.insert(set.seen_test.end(), kWordTestPoints / 8, 255);
  }
  return set;
}

ValidateOptions shortOptions() {
  ValidateOptions options;
  options.threads = 2;
  options.direct_functions = 4;
  options.direct = {200, 2, 1, 1};
  options.policy.refine_rounds = 1;
  options.policy.refine_first_steps = 20;
  options.policy.adam_steps = 20;
  return options;
}

class PolicyWordsTest : public testing::Test {
 protected:
  FunctionSet set_ = smallSet();
  ValidateOptions options_ = shortOptions();
  Populations populations_{set_, options_};
  Generator generator_{sampleGenerator(Representation::tentMlp(), 24, 3, 1)};
  KnownFunctions known_{std::vector<bool>(kCount, false), std::vector<bool>(kCount, false)};
  FigureContext context_{set_, populations_, known_};
};

TEST_F(PolicyWordsTest, PopulationsFollowTheCheckOfTheBareTent) {
  for (uint64_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(populations_.takesTheta(i), i >= kTents) << i;
    EXPECT_EQ(populations_.isHard(i), i >= kTents) << i << ": a wall cuts off more than a hundredth";
  }
  EXPECT_EQ(populations_.sample().size(), 4u);
  EXPECT_EQ(populations_.count(Scope::sample, Population::theta), 4u);
  EXPECT_GE(populations_.sample().front(), uint64_t{kTents});
}

TEST_F(PolicyWordsTest, AFunctionWithoutThetaIsItsBareTentUnderEveryWordAndTakesNoNetwork) {
  const MeasuredWord tents = measureTents(set_, populations_, options_);
  const PolicyWords words = measurePolicy(generator_, set_, populations_, options_);
  for (const MeasuredWord& word : words.words) {
    for (uint64_t i = 0; i < kCount; ++i) {
      const MeasuredFunction& one = word.functions[i];
      EXPECT_EQ(one.function, i);
      if (i < kTents) {
        EXPECT_EQ(one.error.blend_rmse, tents.functions[i].error.blend_rmse) << word.name;
        EXPECT_EQ(one.error.rmse, tents.functions[i].error.rmse) << word.name;
        // the check of the bare tent is all that it takes
        EXPECT_EQ(one.elapsed_us > 0.0, &word != &words.words.front()) << word.name;
        EXPECT_FALSE(one.fitted || one.fails_check) << word.name;
      } else {
        EXPECT_GT(one.elapsed_us, 0.0) << word.name;
      }
    }
  }
  for (uint64_t i = kTents; i < kCount; ++i) {
    EXPECT_FALSE(words.at(ThetaWord::corrected).functions[i].fitted);
    EXPECT_TRUE(words.at(ThetaWord::stored).functions[i].fitted) << "random numbers fail the check, and are refined";
    EXPECT_LT(words.at(ThetaWord::stored).functions[i].error.blend_rmse,
              words.at(ThetaWord::network).functions[i].error.blend_rmse);
  }
  const auto json = figuresByPopulation(words.at(ThetaWord::stored), Scope::set, context_);
  EXPECT_EQ(json["all"]["functions"], kCount);
  EXPECT_EQ(json["theta"]["functions"], kWalls);
  EXPECT_DOUBLE_EQ(json["all"]["share_fitted"]["value"].get<double>(), static_cast<double>(kWalls) / kCount);
  EXPECT_EQ(json["theta"]["share_fitted"]["value"], 1.0);
  EXPECT_EQ(json["theta"]["share_fitted"]["low"], 1.0);
}

TEST_F(PolicyWordsTest, ErrorsAndLeaksAreTheSameOnAnyNumberOfThreads) {
  const PolicyWords two = measurePolicy(generator_, set_, populations_, options_);
  ValidateOptions alone = options_;
  alone.threads = 1;
  const PolicyWords one = measurePolicy(generator_, set_, populations_, alone);
  for (int w = 0; w < kThetaWordCount; ++w) {
    auto a = figuresByPopulation(two.words[w], Scope::set, context_), b = figuresByPopulation(one.words[w], Scope::set, context_);
    for (auto* json : {&a, &b}) {
      for (auto& [name, figures] : json->items()) figures.erase("us_per_function");
    }
    EXPECT_EQ(a.dump(), b.dump());
  }
}

TEST_F(PolicyWordsTest, NothingIsBelowTheBestKnown) {
  for (const ThetaPrecision precision : {ThetaPrecision::float32, ThetaPrecision::int8}) {
    SCOPED_TRACE(thetaPrecisionName(precision));
    options_.policy.theta_precision = precision;
    const PolicyWords words = measurePolicy(generator_, set_, populations_, options_);
    const LongFits fits = measureLongFits(generator_, set_, populations_, words.least_wrong, options_);
    for (size_t n = 0; n < populations_.sample().size(); ++n) {
      // fits sum in float, the meter in double
      const double best = fits.at(LongFit::best_known).functions[n].error.blend_rmse * (1.0 - 1e-5);
      for (const MeasuredWord& fit : fits.words) EXPECT_GE(fit.functions[n].error.blend_rmse, best) << fit.name;
      for (const MeasuredWord& word : words.words) {
        EXPECT_GE(word.functions[populations_.sample()[n]].error.blend_rmse, best) << word.name;
      }
    }
    const auto ratios = ratiosJson(words.at(ThetaWord::stored), fits.at(LongFit::best_known), context_);
    EXPECT_GE(ratios["median"]["value"].get<double>(), 1.0 - 1e-5);
    EXPECT_LE(ratios["median"]["low"].get<double>(), ratios["median"]["value"].get<double>());
  }
}

}  // namespace
}  // namespace nlg
