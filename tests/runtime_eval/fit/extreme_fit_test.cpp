// Fits from hopeless starts, at absurd learning rates, and where J^T J is singular, of networks and product fields.

#include <gtest/gtest.h>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/policy/refinement.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

std::vector<Representation> networksAndFields() {
  std::vector<Representation> all;
  for (const char* name : kRepresentationNames) {
    Representation representation;
    findRepresentation(name, &representation);
    if (!representation.isCode()) all.push_back(representation);
  }
  return all;
}

// A finite start gives a finite theta that is no worse, in no more steps than allowed; any other start is refused.
void expectSound(const Representation& representation, const WeightingFunction& function, const Theta& start,
                 const FitResult& fit, int budget, const std::string& what) {
  const double before = functionRmse(representation, function, start.data());
  EXPECT_LE(fit.steps, budget) << what;
  if (!std::isfinite(before)) {
    EXPECT_EQ(fit.stop, FitStop::not_finite) << what;
    return;
  }
  EXPECT_TRUE(allFinite(fit.theta)) << what;
  EXPECT_LE(fit.rmse, before) << what;
}

struct Start {
  std::string name;
  Theta theta;
  bool saturated = false;    // a sigmoid at its end or a clamp leaves no gradient at all
  bool units_alike = false;  // all units of a layer stay alike: the last bias is all that is left to move
};

std::vector<Start> startsOf(const Representation& representation) {
  const bool is_field = representation.isField(), is_network = representation.isNetwork();
  const bool has_sigmoid = is_network && representation.shape().output == OutputFunction::sigmoid;
  const auto filled = [&](double value) { return Theta(representation.thetaCount(), static_cast<float>(value)); };
  const auto with = [&](int place, double value) {
    Theta theta = randomTheta(representation, 8);
    theta[place] = static_cast<float>(value);
    return theta;
  };
  std::vector<Start> starts = {{"zero", filled(0.0), false, is_network},
                               {"+1e3", filled(1e3), is_field || has_sigmoid},
                               {"-1e3", filled(-1e3), is_field || has_sigmoid},
                               {"+1e-42", filled(1e-42), false, is_network},
                               {"-1e-42", filled(-1e-42), is_field, is_network},
                               {"one 1e30", with(0, 1e30), has_sigmoid},
                               {"one NaN", with(0, NAN)},
                               {"one Inf", with(0, INFINITY)}};
  if (has_sigmoid) {
    for (const float bias : {-90.0f, 90.0f}) starts.push_back({"a last bias", with(representation.shape().b3(), bias), true});
  }
  if (is_field) {
    // A below and above its clamp; the sigmoid of B at its ends
    for (const auto& [a, b] : {std::pair{-2.0f, 0.0f}, {3.0f, 0.0f}, {0.5f, -90.0f}, {0.5f, 90.0f}}) {
      Theta theta = filled(a);
      for (size_t i = 1; i < theta.size(); i += 2) theta[i] = b;
      starts.push_back({"A = " + std::to_string(a) + ", B = " + std::to_string(b), std::move(theta), true});
    }
  }
  return starts;
}

TEST(ExtremeFit, IsSoundFromAnyStartAndLeavesThoseThatAreNotSaturated) {
  const StoredSample wall = wallSample(9);
  for (const Representation& representation : networksAndFields()) {
    const WeightingFunction function = decoded(wall.view(), pointOrder(representation));
    for (const Start& start : startsOf(representation)) {
      NormalEquationsKernel kernel;
      const std::string what = std::string(representationName(representation)) + " from " + start.name;
      const FitResult by_adam = fitAdam(representation, function, start.theta, {.steps = 250});
      const FitResult by_lm = fitLevenbergMarquardt(representation, function, start.theta, {.iterations = 5}, &kernel);
      expectSound(representation, function, start.theta, by_adam, 250, what + " by Adam");
      expectSound(representation, function, start.theta, by_lm, 5, what + " by LM");
      const double before = functionRmse(representation, function, start.theta.data());
      if (!std::isfinite(before) || start.saturated) continue;
      double wanted = 0.5 * before;
      if (start.units_alike) {
        // the lowest error that the last bias alone gives; of a grid, so at least the true one
        Theta theta = start.theta;
        wanted = before;
        for (int i = -32; i <= 32; ++i) {
          theta[representation.shape().b3()] = static_cast<float>(i / 16.0);
          wanted = std::min(wanted, 1.01 * functionRmse(representation, function, theta.data()));
        }
      }
      EXPECT_LE(std::min(by_adam.rmse, by_lm.rmse), wanted) << what;
    }
  }
}

TEST(ExtremeFit, LeavesSaturatedStartsByTheRefinement) {
  const StoredSample wall = wallSample(9);
  Refiner refiner;
  for (const Representation& representation : networksAndFields()) {
    if (representation.thetaCount() > 250) continue;  // larger ones take minutes
    for (const Start& start : startsOf(representation)) {
      if (!start.saturated) continue;
      const double before = FunctionChecker().check(representation, wall.view(), start.theta.data(), {}).blend_rmse;
      const double after =
          refiner.refine(representation, wall.view(), start.theta, randomTheta(representation, 13), {}, {.refine_rounds = 1})
              .check.blend_rmse;
      EXPECT_LT(after, 0.9 * before) << representationName(representation) << " from " << start.name;
    }
  }
}

TEST(ExtremeFit, IsSoundAtAnyLearningRateAndLowersTheErrorAtUsualOnes) {
  for (const Representation& representation : networksAndFields()) {
    const WeightingFunction function = decoded(wallSample(10).view(), pointOrder(representation));
    const Theta start = randomTheta(representation, 9);
    const double before = functionRmse(representation, function, start.data());
    double best = before;
    for (int decade = -5; decade <= 2; ++decade) {
      const FitResult fit = fitAdam(representation, function, start, {.steps = 100, .learning_rate = std::pow(10.0, decade)});
      const std::string what = std::string(representationName(representation)) + " at 1e" + std::to_string(decade);
      expectSound(representation, function, start, fit, 100, what);
      if (decade >= -4 && decade <= -2) {
        EXPECT_LT(fit.rmse, before) << what;
      }
      best = std::min(best, fit.rmse);
    }
    EXPECT_LE(best, 0.5 * before) << representationName(representation);
  }
}

void expectLowered(const Representation& representation, const WeightingFunction& function, const Theta& start) {
  NormalEquationsKernel kernel;
  const FitResult fit = fitLevenbergMarquardt(representation, function, start, {.iterations = 20}, &kernel);
  expectSound(representation, function, start, fit, 20, representationName(representation));
  EXPECT_LT(fit.rmse, functionRmse(representation, function, start.data())) << representationName(representation);
}

TEST(ExtremeFit, LowersTheErrorWhereNormalEquationsAreSingular) {
  // pairs of units that are the same: what one of them could learn the other one learns too
  Theta twins = randomTheta(Representation::tentMlp(), 4);
  for (int unit = 1; unit < kHiddenCount; unit += 2) {
    for (int i = 0; i < 3; ++i) twins[ThetaLayout::w1 + 3 * unit + i] = twins[ThetaLayout::w1 + 3 * (unit - 1) + i];
    twins[ThetaLayout::b1 + unit] = twins[ThetaLayout::b1 + unit - 1];
    for (int row = 0; row < kHiddenCount; ++row) {
      twins[ThetaLayout::w2 + kHiddenCount * row + unit] = twins[ThetaLayout::w2 + kHiddenCount * row + unit - 1];
    }
  }
  expectLowered(Representation::tentMlp(), decoded(wallSample(6).view()), twins);
  // all points in one corner, a handful of cells of 9³ nodes
  StoredSample corner;
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = supportPattern().points[p];
    if (*std::min_element(point.begin(), point.end()) <= 0.6f) continue;
    corner.validity[p / 8] |= static_cast<uint8_t>(1 << p % 8);
    corner.phi[p] = static_cast<uint8_t>(std::lround(255 * std::min(1.0f, 4.0f * tent(point))));
  }
  const Representation field = Representation::productField(9);
  expectLowered(field, decoded(corner.view(), pointOrder(field)), randomTheta(field, 6));
}

}  // namespace
}  // namespace nlg
