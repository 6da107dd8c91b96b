// The stages of a representation and the functions that take them: a list, from the options and the properties of the
// generator.
#pragma once

#include <string>
#include <vector>

#include "nlg/policy.h"

namespace nlg {

// One line of the list.
struct StagePlan {
  // Which functions take the stage.
  enum class Who : uint8_t {
    all,      // that have a theta
    wrong,    // whose RMSE is above `above_rmse`, or that fail the check, as the network left them
    above,    // of these, whose blend RMSE is still above `above_rmse`
    failing,  // that fail the check
  };
  ThetaStage stage = ThetaStage::network;
  Who who = Who::all;
  double above_rmse = 0.0;
  int budget = 0;  // iterations, Adam's steps, rounds; 0 where the stage has none
};

// "Levenberg-Marquardt from theta0, 32 iterations at most: those of them whose blend RMSE is still above 0.005".
std::string describe(const StagePlan& plan);
// Its parts: "32 iterations at most", empty for a stage without a budget; "those of them whose blend RMSE is still above 0.005".
std::string budgetText(const StagePlan& plan);
std::string takersText(const StagePlan& plan);

// What the list depends on beside the options.
struct StageFacts {
  Representation representation;
  bool exact_last_layer = false;  // the weights say that it is solved
  double tent_rmse = 0.0;         // of the network's theta for the bare tent: what it cannot do better for any function
};
StageFacts stageFacts(const Generator& generator);

// Whether a theta is good as it stands: what the network leaves so takes no other stage.
bool isGood(const FunctionCheck& theta, double good_rmse, const CheckOptions& check);

// The stages of one representation in their order, the refinement last. What the options leave out is not there.
std::vector<StagePlan> stagesOf(const StageFacts& facts, const PolicyOptions& options);

}  // namespace nlg
