// The stages that a theta goes through on its way from the generator to the light grid: their names, their order, their interface.
//
// Four words sum them up, in every table of this project: *network* (one pass of the generator's network), *corrected* (and the last
// layer solved exactly), *fitted* (and any step of Adam or Levenberg–Marquardt), *stored* (what the grid holds).
// Which stages a representation goes through is data: stagesOf (stage_plan.h).
#pragma once

#include <cstdint>

namespace nlg {

// In the order in which a function meets them.
enum class ThetaStage : uint8_t {
  bare_tent,   // no theta: the bare tent is enough
  network,     // one pass of the generator's network
  last_layer,  // the last layer solved exactly
  lm,          // Levenberg–Marquardt
  lm_theta0,   // … from theta0
  adam,        // a short run of Adam
  refinement,  // fits on until the check passes, in rounds
  larger,      // the same for the next larger representation
  rounding,    // to the light grid's precision
  check,       // whether theta may stand for its function: after each of the words below
};
inline constexpr int kThetaStageCount = 10;

enum class ThetaWord : uint8_t { network, corrected, fitted, stored };
inline constexpr int kThetaWordCount = 4;

// "exact last layer"; a key for files: "last_layer"; "corrected".
const char* stageTitle(ThetaStage stage);
const char* stageName(ThetaStage stage);
const char* wordName(ThetaWord word);
// The word that theta has earned with this stage; rounding and bare tents: stored. Not of `check`.
ThetaWord wordOf(ThetaStage stage);
// Whether it takes steps of Adam or Levenberg–Marquardt.
bool isFit(ThetaStage stage);

class ThetaBatch;

// One stage at work: offers better theta for some functions of a batch. It allocates nothing, once it is made.
class StageRun {
 public:
  virtual ~StageRun() = default;
  // members   indices into the batch, rising
  virtual void run(ThetaBatch& batch, const int* members, int member_count) = 0;
};

}  // namespace nlg
