
#include <gtest/gtest.h>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/policy/stage_plan.h"
#include "runtime_eval/policy/stage_runner.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

// Walls, and a bare tent in every fifth place.
struct Functions {
  explicit Functions(int count) {
    for (int i = 0; i < count; ++i) samples.push_back(i % 5 == 4 ? tentSample() : wallSample(static_cast<uint64_t>(i)));
    for (const StoredSample& sample : samples) views.push_back(sample.view());
  }
  std::vector<StoredSample> samples;
  std::vector<StoredFunction> views;
};

Generator solvedGenerator(const Representation& representation, uint64_t seed = 1) {
  GeneratorData data = sampleGenerator(representation, 48, 3, seed);
  data.exact_last_layer = representation.hasLinearOutput();
  return Generator(data);
}

// Short, and with limits that some functions pass and others do not.
PolicyOptions shortOptions() {
  PolicyOptions options;
  options.theta_precision = ThetaPrecision::float32;
  options.adam_steps = 40;
  options.tau_rmse = 0.05;
  options.refine_rounds = 1;
  options.refine_first_steps = 60;
  return options;
}

TEST(TakesBareTent, SaysNoWhereTheTentLeaksIntoFewPointsBehindAWall) {
  StoredSample sample = tentSample();
  FunctionChecker checker;
  const PolicyOptions options;
  EXPECT_TRUE(takesBareTent(checker.checkBareTent(sample.view(), options.check()), options));
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = supportPattern().points[p];
    if (point[0] > 0.9f && point[1] > 0.7f) sample.phi[p] = 0;
  }
  const FunctionCheck leaking = checker.checkBareTent(sample.view(), options.check());
  ASSERT_LE(leaking.rmse, options.bare_tent_rmse) << "its error is small enough";
  EXPECT_FALSE(takesBareTent(leaking, options));
}

TEST(ThetaPolicy, GivesAFunctionTheSameThetaWhateverStandsBesideIt) {
  const Functions functions(2 * kBatchCount + 7);
  const auto count = static_cast<int>(functions.views.size());
  for (const Representation& representation :
       {Representation::tentMlp(), Representation{RepresentationKind::tent_mlp4}, Representation::productField(3),
        Representation::code(sampleDictionary(5, 32, 1))}) {
    const Generator generator = solvedGenerator(representation);
    ThetaPolicy policy({&generator}, shortOptions());
    std::vector<MadeTheta> together(count);
    policy.bake(functions.views.data(), count, together.data());
    int bare = 0;
    for (int i = 0; i < count; i += 7) {
      MadeTheta alone;
      policy.bake(&functions.views[i], 1, &alone);
      EXPECT_EQ(alone.theta, together[i].theta) << "function " << i;
      EXPECT_EQ(alone.record.ended, together[i].record.ended) << "function " << i;
      EXPECT_EQ(alone.record.took_fit, together[i].record.took_fit) << "function " << i;
      for (int w = 0; w < kThetaWordCount; ++w) {
        EXPECT_EQ(alone.record.check[w].rmse, together[i].record.check[w].rmse) << "function " << i << ", word " << w;
      }
      EXPECT_EQ(alone.isBareTent(), i % 5 == 4) << "function " << i;
      bare += alone.isBareTent();
    }
    EXPECT_GT(bare, 0);
  }
}

TEST(ThetaPolicy, ALaterWordIsNeverInTroubleThatTheOneBeforeWasNot) {
  const Functions functions(60);
  PolicyOptions options = shortOptions();
  // the RMSE decides, which is not what fits minimise
  options.check() = {0.03, 1e3, 1.0, 64.0, 0.2};
  for (const Representation& representation : {Representation::tentMlp(), Representation::productField(3)}) {
    for (uint64_t seed = 1; seed < 4; ++seed) {
      const Generator generator = solvedGenerator(representation, seed);
      std::vector<MadeTheta> made(functions.views.size());
      ThetaPolicy({&generator}, options).bake(functions.views.data(), static_cast<int>(made.size()), made.data());
      for (size_t i = 0; i < made.size(); ++i) {
        for (int w = 1; w < kThetaWordCount; ++w) {
          if (!made[i].record.check[w - 1].passes(options.check())) continue;
          EXPECT_TRUE(made[i].record.check[w].passes(options.check())) << "function " << i << ", word " << w;
        }
      }
    }
  }
}

TEST(ThetaPolicy, RoundsToFloat16AndChecksWhatThatMakesOfIt) {
  const Functions functions(10);
  const Generator generator = solvedGenerator(Representation::tentMlp());
  PolicyOptions options = shortOptions();
  options.refine_rounds = 0;  // what rounding alone makes fail is not fitted on
  std::vector<MadeTheta> full(functions.views.size()), half(full);
  ThetaPolicy({&generator}, options).bake(functions.views.data(), static_cast<int>(full.size()), full.data());
  options.theta_precision = ThetaPrecision::float16;
  ThetaPolicy({&generator}, options).bake(functions.views.data(), static_cast<int>(half.size()), half.data());
  FunctionChecker checker;
  for (size_t i = 0; i < full.size(); ++i) {
    if (full[i].isBareTent()) continue;
    bool differs = false;
    for (size_t d = 0; d < full[i].theta.size(); ++d) {
      // half a unit in the last of 11 bits, and the smallest half
      EXPECT_NEAR(half[i].theta[d], full[i].theta[d], std::fabs(full[i].theta[d]) * 0x1p-11 + 0x1p-25) << i;
      differs = differs || half[i].theta[d] != full[i].theta[d];
    }
    EXPECT_TRUE(differs) << i;
    EXPECT_EQ(half[i].check().rmse,
              checker.check(generator.representation(), functions.views[i], half[i].theta.data(), options.check()).rmse);
    EXPECT_EQ(half[i].record.at(ThetaWord::fitted).rmse, full[i].record.at(ThetaWord::fitted).rmse);
  }
}

TEST(ThetaPolicy, LosesLittleByHiddenLayersInInt8) {
  const Functions functions(10);
  for (const Representation& representation :
       {Representation::mlp(), Representation::tentMlp(), Representation{RepresentationKind::tent_mlp4}}) {
    const Generator generator = solvedGenerator(representation);
    PolicyOptions options = shortOptions();
    options.theta_precision = ThetaPrecision::int8;
    std::vector<MadeTheta> made(functions.views.size());
    const int count = static_cast<int>(made.size());
    ThetaPolicy({&generator}, options).bake(functions.views.data(), count, made.data());
    FunctionChecker checker;
    int thetas = 0;
    for (size_t i = 0; i < made.size(); ++i) {
      if (made[i].isBareTent()) continue;
      ++thetas;
      Theta again = made[i].theta;
      ASSERT_TRUE(roundTheta(representation, ThetaPrecision::int8, again.data()));
      EXPECT_EQ(again, made[i].theta) << i;
      const double fitted = made[i].record.at(ThetaWord::fitted).rmse, stored = made[i].check().rmse;
      EXPECT_EQ(stored, checker.check(representation, functions.views[i], made[i].theta.data(), options.check()).rmse);
      EXPECT_LE(stored, 1.1 * fitted) << i;
      EXPECT_TRUE(made[i].check().passes(options.check()) || !made[i].record.at(ThetaWord::fitted).passes(options.check())) << i;
    }
    EXPECT_GT(thetas, 0);
  }
}

// A check that the unrounded theta passes and hardly any rounding of it: what fails for rounding alone is fitted on, if fits may.
TEST(ThetaPolicy, FitsOnWhereRoundingAloneMakesAFunctionFail) {
  const Functions functions(20);
  const Representation representation = Representation::mlp();
  const Generator generator = solvedGenerator(representation);
  int mended = 0, left = 0;
  for (const StoredFunction& function : functions.views) {
    PolicyOptions options = shortOptions();
    options.refine_first_steps = 600;
    options.dark_weight = options.blend_floor = 1.0;  // the check asks for an RMSE alone
    MadeTheta made;
    ThetaPolicy({&generator}, options).make(&function, 1, &made);
    options.theta_precision = ThetaPrecision::int8;
    const double most = made.check().rmse * 1.00001;
    options.check() = {most, most, 1.0, 1.0, 1.0};
    MadeTheta fitted_on = made, as_it_was = made;
    ThetaPolicy({&generator}, options).round(function, &fitted_on);
    options.refine_rounds = 0;
    ThetaPolicy({&generator}, options).round(function, &as_it_was);
    EXPECT_FALSE(as_it_was.record.refined);
    EXPECT_LE(fitted_on.check().trouble(options.check()), as_it_was.check().trouble(options.check()));
    if (as_it_was.check().passes(options.check())) {
      EXPECT_EQ(fitted_on.theta, as_it_was.theta);
      continue;
    }
    EXPECT_TRUE(fitted_on.record.refined && fitted_on.record.took_fit);
    EXPECT_EQ(fitted_on.record.at(ThetaWord::fitted).rmse, made.check().rmse);
    ++(fitted_on.check().passes(options.check()) ? mended : left);
  }
  EXPECT_GT(mended, left);
}

TEST(ThetaPolicy, StoresTheLargestHalfForWhatIsBeyondAndChecksThat) {
  const Functions functions(1);
  for (const Representation& representation : {Representation::productField(3), Representation::tentMlp()}) {
    const Generator generator = solvedGenerator(representation);
    for (const ThetaPrecision precision : {ThetaPrecision::float16, ThetaPrecision::int8}) {
      PolicyOptions options = shortOptions();
      options.bare_tent_rmse = 0.0;
      options.refine_rounds = 0;  // what rounding makes fail stays
      options.theta_precision = precision;
      ThetaPolicy policy({&generator}, options);
      MadeTheta made;
      policy.make(functions.views.data(), 1, &made);
      made.theta.back() = -272096.0f;  // of a node's pair (A, B) the logit, as fits have left it
      // of a network a hidden number, too, by which its readers are scaled
      if (!representation.isField()) made.theta[0] = made.theta[representation.shape().w2()] = 3e38f;
      policy.round(functions.views[0], &made);
      EXPECT_TRUE(allFinite(made.theta));
      Theta again = made.theta;
      ASSERT_TRUE(roundTheta(representation, precision, again.data())) << "it can be stored";
      EXPECT_EQ(again, made.theta);
      if (representation.isField()) {
        EXPECT_EQ(made.theta.back(), -kMaxHalf);
      }
      FunctionChecker checker;
      EXPECT_EQ(made.check().rmse, checker.check(representation, functions.views[0], made.theta.data(), options.check()).rmse);
    }
  }
}

}  // namespace
}  // namespace nlg
