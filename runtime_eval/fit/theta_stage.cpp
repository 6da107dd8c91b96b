#include "runtime_eval/fit/theta_stage.h"

#include <cstdio>
#include <iterator>

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
    {"learned_steps", "learned steps", ThetaWord::corrected, false},
    {"mirror_images", "mirror images", ThetaWord::corrected, false},
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

const char* unitOf(ThetaStage stage, int budget) {
  const bool one = budget == 1;
  switch (stage) {
    case ThetaStage::learned_steps:
      return one ? "step at most" : "steps at most";
    case ThetaStage::mirror_images:
      return "attempts at most, the function itself included";
    case ThetaStage::lm:
    case ThetaStage::lm_theta0:
      return one ? "iteration at most" : "iterations at most";
    case ThetaStage::adam:
      return one ? "step for each .01 of RMSE, 4 at most" : "steps for each .01 of RMSE, 4 times as many at most";
    case ThetaStage::refinement:
    case ThetaStage::larger:
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
      return std::string("functions that the network left above an RMSE of ") + rmse + " or failing the check";
    case StagePlan::Who::above:
      return std::string("those of them whose RMSE is still above ") + rmse;
    case StagePlan::Who::failing:
      return "functions that fail the check";
  }
  return "";
}

std::string describe(const StagePlan& plan) {
  const std::string budget = budgetText(plan);
  return stageTitle(plan.stage) + (budget.empty() ? "" : ", " + budget) + ": " + takersText(plan);
}

}  // namespace nlg
