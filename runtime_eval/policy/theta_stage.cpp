#include "nlg/policy.h"

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

}  // namespace nlg
