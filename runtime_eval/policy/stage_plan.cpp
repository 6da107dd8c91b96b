#include "runtime_eval/policy/stage_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/fit_result.h"
#include "runtime_eval/fit/last_layer.h"

namespace nlg {
namespace {

struct StageText {
  const char *name, *title;
  ThetaWord word;
  bool is_fit;
};

// by ThetaStage
constexpr StageText kStages[] = {
    {"bare_tent", "bare tent", ThetaWord::stored, false},
    {"network", "network", ThetaWord::network, false},
    {"last_layer", "exact last layer", ThetaWord::corrected, false},
    {"lm", "Levenberg-Marquardt", ThetaWord::fitted, true},
    {"lm_theta0", "Levenberg-Marquardt from theta0", ThetaWord::fitted, true},
    {"adam", "Adam", ThetaWord::fitted, true},
    {"refinement", "refinement", ThetaWord::fitted, true},
    {"larger", "larger representation", ThetaWord::fitted, true},
    {"rounding", "rounding", ThetaWord::stored, false},
    {"check", "check", ThetaWord::stored, false},
};
static_assert(std::size(kStages) == kThetaStageCount);

const StageText& textOf(ThetaStage stage) { return kStages[static_cast<size_t>(stage)]; }

// A generator that is wrong about the bare tent is about as wrong about every function, and no fit of a few steps changes that. Its
// thresholds rise to kOverTent times that error, but to no more than kMostRetry times retry_rmse.
constexpr double kOverTent = 1.25, kMostRetry = 2.0;

const char* unitOf(ThetaStage stage, int budget) {
  const bool one = budget == 1;
  switch (stage) {
    case ThetaStage::lm:
    case ThetaStage::lm_theta0:
      return one ? "iteration at most" : "iterations at most";
    case ThetaStage::adam:
      return one ? "step for each .01 of blend RMSE, 4 at most" : "steps for each .01 of blend RMSE, 4 times as many at most";
    case ThetaStage::refinement:
      return one ? "round at most" : "rounds at most";
    default:
      return "";
  }
}

}  // namespace

const char* stageTitle(ThetaStage stage) { return textOf(stage).title; }
const char* stageName(ThetaStage stage) { return textOf(stage).name; }
ThetaWord wordOf(ThetaStage stage) { return textOf(stage).word; }
bool isFit(ThetaStage stage) { return textOf(stage).is_fit; }

const char* wordName(ThetaWord word) {
  constexpr const char* kNames[] = {"network", "corrected", "fitted", "stored"};
  static_assert(std::size(kNames) == kThetaWordCount);
  return kNames[static_cast<size_t>(word)];
}

std::string budgetText(const StagePlan& plan) {
  return plan.budget > 0 ? std::to_string(plan.budget) + ' ' + unitOf(plan.stage, plan.budget) : "";
}

std::string takersText(const StagePlan& plan) {
  char rmse[32];
  std::snprintf(rmse, sizeof rmse, "%.4g", plan.above_rmse);
  switch (plan.who) {
    case StagePlan::Who::all:
      return "all functions";
    case StagePlan::Who::wrong:
      return std::string("functions that the network left above a blend RMSE of ") + rmse + " or failing the check";
    case StagePlan::Who::above:
      return std::string("those of them whose blend RMSE is still above ") + rmse;
    case StagePlan::Who::failing:
      return "functions that fail the check";
  }
  return "";
}

std::string describe(const StagePlan& plan) {
  const std::string budget = budgetText(plan);
  return stageTitle(plan.stage) + (budget.empty() ? "" : ", " + budget) + ": " + takersText(plan);
}

StageFacts stageFacts(const Generator& generator) {
  const Representation& representation = generator.representation();
  std::vector<uint8_t> phi(kSupportPointCount);
  for (int p = 0; p < kSupportPointCount; ++p) {
    phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
  }
  const std::vector<uint8_t> validity(kValidityByteCount, 0xff);
  GeneratorScratch scratch(generator);
  Theta theta(representation.thetaCount());
  const StoredFunction tent_function{phi.data(), validity.data()};
  generator.generate(&tent_function, 1, theta.data(), &scratch);
  const WeightingFunction function = tentFunction(pointOrder(representation));
  if (generator.exactLastLayer()) solveLastLayer(representation, function, theta.data());
  return {representation, generator.exactLastLayer(), functionRmse(representation, function, theta.data())};
}

bool isGood(const FunctionCheck& theta, double good_rmse, const CheckOptions& check) {
  return theta.blend_rmse <= good_rmse && theta.passes(check);
}

std::vector<StagePlan> stagesOf(const StageFacts& facts, const PolicyOptions& options) {
  using Who = StagePlan::Who;
  const double tent_rmse = std::isfinite(facts.tent_rmse) ? facts.tent_rmse : 0.0;
  const double least_rmse = std::min(kOverTent * tent_rmse, kMostRetry * options.retry_rmse);
  std::vector<StagePlan> plan = {{ThetaStage::network, Who::all, 0.0, 0}};
  if (facts.exact_last_layer) plan.push_back({ThetaStage::last_layer, Who::wrong, options.good_rmse, 0});
  // a budget of 0 leaves a fit out
  const auto addFit = [&](ThetaStage stage, Who who, double above_rmse, int budget) {
    if (budget > 0) plan.push_back({stage, who, above_rmse, budget});
  };
  if (facts.representation.isField()) {
    addFit(ThetaStage::lm, Who::wrong, options.good_rmse, options.lm_iterations);
    addFit(ThetaStage::lm_theta0, Who::above, std::max(options.retry_rmse, least_rmse), options.lm_theta0_iterations);
  } else if (facts.representation.isCode()) {
    addFit(ThetaStage::lm, Who::wrong, options.good_rmse, options.code_iterations);
  } else {
    addFit(ThetaStage::adam, Who::above, std::max(options.adam_rmse, least_rmse), options.adam_steps);
  }
  addFit(ThetaStage::refinement, Who::failing, 0.0, options.refine_rounds);
  return plan;
}

}  // namespace nlg
