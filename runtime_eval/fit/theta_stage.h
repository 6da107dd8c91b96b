// The stages that a theta goes through on its way from the generator to the light grid: their names, their order, their interface.
//
// Four words sum them up, in every table of this project: *network* (one pass of the generator's network), *corrected* (whatever
// needs no iterative fit), *fitted* (any step of Adam or Levenberg–Marquardt after that), *stored* (what the grid holds).
// Which stages a representation goes through is data: stagesOf (theta_policy.h).
#pragma once

#include <cstdint>
#include <string>

namespace nlg {

struct StageOptions {
  double good_rmse = 0.001;   // a theta of the network whose RMSE is not above, and that passes the check, takes no other stage
  int learned_steps = 0;      // of an attempt at most: they end at the first that does not pay; 0: none
  int mirror_images = 1;      // networks: attempts at a function at most, itself and then its mirror images; 1 … 8
  double retry_rmse = 0.005;  // no further attempt at a function whose RMSE is not above; up to twice that for a generator that
                              // is nearly as wrong about the tent
  int lm_iterations = 8;      // where they are cheap: of Levenberg–Marquardt, after the corrections
  int lm_theta0_iterations = 32;  // … and from theta0, for a function whose RMSE is above retry_rmse even then
  double adam_rmse = 0.002;       // elsewhere: a function whose RMSE is above (raised as retry_rmse is) …
  int adam_steps = 1000;          // … takes so many steps of Adam for each .01 of it, 4 times as many at most
};

// In the order in which a function meets them.
enum class ThetaStage : uint8_t {
  bare_tent,      // no theta: the bare tent is enough
  network,        // one pass of the generator's network
  last_layer,     // the last layer solved exactly
  learned_steps,  // the correction network, step by step
  mirror_images,  // the three above, for mirror images of the function
  lm,             // Levenberg–Marquardt
  lm_theta0,      // … from theta0
  adam,           // a short run of Adam
  refinement,     // fits on until the check passes, in rounds
  larger,         // the same for the next larger representation
  rounding,       // to the light grid's precision
  check,          // whether theta may stand for its function: after each of the words below
};
inline constexpr int kThetaStageCount = 12;

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

// One line of the list that a representation goes through.
struct StagePlan {
  // Which functions take the stage.
  enum class Who : uint8_t {
    all,      // that have a theta
    wrong,    // whose RMSE is above `above_rmse`, or that fail the check, as the network left them
    above,    // of these, whose RMSE is still above `above_rmse`
    failing,  // that fail the check
  };
  ThetaStage stage = ThetaStage::network;
  Who who = Who::all;
  double above_rmse = 0.0;
  int budget = 0;  // learned steps, attempts, iterations, Adam's steps, rounds; 0 where the stage has none
};

// "Levenberg-Marquardt from theta0, 32 iterations at most: those of them whose RMSE is still above 0.005".
std::string describe(const StagePlan& plan);
// Its parts: "32 iterations at most", empty for a stage without a budget; "those of them whose RMSE is still above 0.005".
std::string budgetText(const StagePlan& plan);
std::string takersText(const StagePlan& plan);

class ThetaBatch;

// One stage at work: offers better theta for some functions of a batch. It allocates nothing, once it is made.
class StageRun {
 public:
  virtual ~StageRun() = default;
  // members   indices into the batch, rising; may be changed
  virtual void run(ThetaBatch& batch, int* members, int member_count) = 0;
};

}  // namespace nlg
