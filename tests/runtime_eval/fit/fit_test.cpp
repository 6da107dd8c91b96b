#include <gtest/gtest.h>

#include <cstring>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

Theta filled(float value) {
  Theta theta(ThetaLayout::count);
  std::fill(theta.begin(), theta.end(), value);
  return theta;
}

struct Fitter {
  const char* name;
  FitResult (*fit)(const Representation&, const WeightingFunction&, const Theta&);
};

const Fitter kFitters[] = {{"Adam", [](const Representation& r, const WeightingFunction& f,
                                       const Theta& t) { return fitAdam(r, f, t, refinementAdam(r, 40)); }},
                           {"Adam, random start", [](const Representation& r, const WeightingFunction& f,
                                                     const Theta& t) { return fitAdam(r, f, t, randomStartAdam(r, 40)); }},
                           {"LM", [](const Representation& r, const WeightingFunction& f, const Theta& t) {
                              NormalEquationsKernel kernel;
                              return fitLevenbergMarquardt(r, f, t, {.iterations = 6}, &kernel);
                            }}};

// The promises that hold whatever goes in. Returns the result.
FitResult expectNeverWorse(const Fitter& fitter, const Representation& representation, const WeightingFunction& function,
                           const Theta& start, const std::string& what) {
  FitResult result = fitter.fit(representation, function, start);
  const double before = functionRmse(representation, function, start.data());
  EXPECT_TRUE(std::isfinite(result.rmse)) << fitter.name << ", " << what;
  EXPECT_LE(result.rmse, before) << fitter.name << ", " << what;
  EXPECT_EQ(result.rmse, functionRmse(representation, function, result.theta.data())) << fitter.name << ", " << what;
  for (const float value : result.theta) EXPECT_TRUE(std::isfinite(value)) << fitter.name << ", " << what;
  return result;
}

TEST(Fit, NeverReturnsWorseThanItsStart) {
  for (const Fitter& fitter : kFitters) {
    for (const Representation& representation : kNetworkRepresentations) {
      for (uint64_t seed = 0; seed < 24; ++seed) {
        const WeightingFunction function = decoded(seed % 3 ? wallSample(seed).view() : noiseSample(seed).view());
        expectNeverWorse(fitter, representation, function, randomTheta(representation, seed), "seed " + std::to_string(seed));
      }
    }
  }
}

TEST(Fit, ReturnsTheStartWhenNumbersAreNotFinite) {
  const WeightingFunction function = decoded(wallSample(6).view());
  for (const Fitter& fitter : kFitters) {
    for (const float bad : {NAN, INFINITY, -INFINITY, 1e30f}) {
      for (const int place : {ThetaLayout::w1, ThetaLayout::b2, ThetaLayout::w3, ThetaLayout::b3}) {
        Theta start = randomTheta({}, 6);
        start[place] = bad;
        const FitResult result = fitter.fit({}, function, start);
        EXPECT_EQ(result.stop, FitStop::not_finite) << fitter.name << ", theta " << place << " = " << bad;
        EXPECT_TRUE(sameBits(result.theta, start)) << fitter.name << ", theta " << place;
        EXPECT_EQ(result.steps, 0) << fitter.name;
      }
    }
    WeightingFunction broken = function;
    for (int i = 0; i < kSupportPointCount; ++i) {
      if (broken.mask[i] != 0.0f) broken.phi[i] = NAN;
    }
    EXPECT_EQ(fitter.fit({}, broken, randomTheta({}, 6)).stop, FitStop::not_finite) << fitter.name << ", function of NaN";
  }
}

// A bake keeps one workspace a thread: what it holds of the function before must not reach the next one.
TEST(Fit, GivesTheSameBitsFromAUsedWorkspace) {
  const Representation tent_mlp = Representation::tentMlp(0.01f);
  const WeightingFunction function = decoded(wallSample(9).view()), before = decoded(noiseSample(9).view());
  const AdamOptions adam = refinementAdam(tent_mlp, 40);
  const LevenbergMarquardtOptions levenberg{.iterations = 6};
  NormalEquationsKernel fresh_kernel, used_kernel;
  const FitResult fresh_adam = fitAdam(tent_mlp, function, randomTheta(tent_mlp, 9), adam),
                  fresh_levenberg = fitLevenbergMarquardt(tent_mlp, function, randomTheta(tent_mlp, 9), levenberg, &fresh_kernel);
  AdamWorkspace adam_workspace;
  LevenbergMarquardtWorkspace levenberg_workspace;
  // larger, smaller and as large as what follows
  for (const Representation& other :
       {Representation::mlp(0.3f), Representation{RepresentationKind::tent_mlp4, 0.01f}, tent_mlp}) {
    Theta theta = randomTheta(other, 10);
    iterateAdam(other, before, adam, &adam_workspace, theta.data());
    iterateLevenbergMarquardt(other, before, levenberg, &used_kernel, &levenberg_workspace, theta.data());
    Theta after_adam = randomTheta(tent_mlp, 9), after_levenberg = after_adam;
    const FitResult adam_result = iterateAdam(tent_mlp, function, adam, &adam_workspace, after_adam.data());
    const FitResult levenberg_result =
        iterateLevenbergMarquardt(tent_mlp, function, levenberg, &used_kernel, &levenberg_workspace, after_levenberg.data());
    EXPECT_TRUE(sameBits(after_adam, fresh_adam.theta)) << "Adam after " << representationName(other);
    EXPECT_EQ(adam_result.rmse, fresh_adam.rmse) << "Adam after " << representationName(other);
    EXPECT_TRUE(sameBits(after_levenberg, fresh_levenberg.theta)) << "LM after " << representationName(other);
    EXPECT_EQ(levenberg_result.rmse, fresh_levenberg.rmse) << "LM after " << representationName(other);
  }
}

TEST(Fit, IgnoresInvalidPoints) {
  StoredSample sample = wallSample(11);
  const WeightingFunction function = decoded(sample.view());
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (!sample.valid(p)) sample.phi[p] = static_cast<uint8_t>(p % 251);
  }
  for (const Fitter& fitter : kFitters) {
    EXPECT_EQ(fitter.fit({}, function, randomTheta({}, 11)).theta,
              fitter.fit({}, decoded(sample.view()), randomTheta({}, 11)).theta)
        << fitter.name;
  }
}

TEST(LevenbergMarquardt, ReachesTheTentExactlyWithTheTentFactor) {
  // With theta = 0 only the output's bias has a derivative: one linear unknown, whose error a damping of at most 0.1 divides by
  // at least 11 a step. Eight steps leave 11^-8 < 1e-8 of it, and float stores the rest.
  NormalEquationsKernel kernel;
  const Representation tent_mlp = Representation::tentMlp(0.01f);
  const FitResult result = fitLevenbergMarquardt(tent_mlp, tentFunction(), filled(0.0f), {.iterations = 8}, &kernel);
  EXPECT_LE(result.rmse, 1e-7);
  EXPECT_NEAR(result.theta[ThetaLayout::b3], 1.0, 2e-7);
}

TEST(LevenbergMarquardt, ArrivesAtTheBestConstantFromZero) {
  // from theta = 0 the bias is the only way down: LM must arrive at the mean over valid points, and move nothing else
  const WeightingFunction function = decoded(wallSample(14).view());
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kSupportPointCount; ++i) {
    if (function.mask[i] != 0.0f) sum += function.phi[i], squares += double{function.phi[i]} * function.phi[i];
  }
  const double count = function.validCount(), mean = sum / count, best = std::sqrt(squares / count - mean * mean);
  NormalEquationsKernel kernel;
  const FitResult result = fitLevenbergMarquardt({}, function, filled(0.0f), {.iterations = 12}, &kernel);
  // Float sums: 64 + 2 roundings in a block of 256 points and 32 over the blocks, of values up to 1 (normal equations, twice: their
  // two sides). What is left of the bias' error d adds d² / (2 best) to the RMSE, less than float's own 66 roundings of residuals
  // up to 1.
  EXPECT_NEAR(result.theta[ThetaLayout::b3], mean, 2 * (64 + 2 + 32) * kFloatRounding);
  EXPECT_NEAR(result.rmse, best, 66 * kFloatRounding / (2 * best));
  for (int i = 0; i < ThetaLayout::count; ++i) {
    if (i == ThetaLayout::b3) continue;
    EXPECT_EQ(result.theta[i], 0.0f) << "theta " << i;
  }
}

// Every candidate of the header, fitted here by itself: the result is the lowest of them, and each of them is needed somewhere.
TEST(FitDirect, IsTheBestOfItsCandidates) {
  NormalEquationsKernel kernel;
  const DirectOptions options{.adam_steps = 60, .levenberg_iterations = 4, .restarts = 2};
  const Representation tent_mlp = Representation::tentMlp(0.01f);
  const LevenbergMarquardtOptions polish = refinementLevenbergMarquardt(tent_mlp, options.levenberg_iterations);
  int wins[4] = {};  // LM from theta0; Adam and LM from theta0, from the first random start, from the second
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const WeightingFunction function = decoded(wallSample(seed).view());
    const Theta theta0 = randomTheta({}, seed);
    const FitResult best = fitDirect(tent_mlp, function, theta0, options, &kernel);
    const auto adam = [&](const Theta& start, const AdamOptions& how) { return fitAdam(tent_mlp, function, start, how); };
    const auto levenberg = [&](const Theta& start) { return fitLevenbergMarquardt(tent_mlp, function, start, polish, &kernel); };
    std::vector<FitResult> candidates = {levenberg(theta0),
                                         levenberg(adam(theta0, refinementAdam(tent_mlp, options.adam_steps)).theta)};
    for (int restart = 0; restart < options.restarts; ++restart) {
      const Theta start = randomTheta(tent_mlp, mixSeed(options.seed, restart));
      candidates.push_back(levenberg(adam(start, randomStartAdam(tent_mlp, options.adam_steps)).theta));
    }
    size_t lowest = 0;
    for (size_t i = 1; i < candidates.size(); ++i) {
      if (candidates[i].rmse < candidates[lowest].rmse) lowest = i;
    }
    ++wins[lowest];
    EXPECT_EQ(best.theta, candidates[lowest].theta) << "seed " << seed << ", candidate " << lowest;
    EXPECT_EQ(best.rmse, functionRmse(tent_mlp, function, best.theta.data())) << "seed " << seed;
  }
  for (int i = 0; i < 4; ++i)
    EXPECT_GT(wins[i], 0) << "candidate " << i << " never was the lowest: these functions do not test it";
}

// With nothing fitted on, the best of the short fits is what remains; what is fitted on is never worse.
TEST(FitStart, IsTheBestShortRandomFitOrBetter) {
  NormalEquationsKernel kernel;
  const WeightingFunction function = decoded(wallSample(16).view());
  const StartOptions fitted_on{
      .candidates = 6, .candidate_steps = 40, .finalists = 2, .final_steps = 40, .levenberg_iterations = 3};
  StartOptions short_only = fitted_on;
  short_only.finalists = 1, short_only.final_steps = 0, short_only.levenberg_iterations = 0;
  FitResult shortest;
  for (int i = 0; i < fitted_on.candidates; ++i) {
    const Theta start = randomTheta({}, mixSeed(fitted_on.seed, static_cast<uint64_t>(i)));
    const FitResult fit = fitAdam({}, function, start, randomStartAdam({}, fitted_on.candidate_steps));
    if (i == 0 || fit.rmse < shortest.rmse) shortest = fit;
  }
  EXPECT_EQ(fitStart({}, function, short_only, &kernel).theta, shortest.theta);
  EXPECT_LT(fitStart({}, function, fitted_on, &kernel).rmse, shortest.rmse);
}

}  // namespace
}  // namespace nlg
