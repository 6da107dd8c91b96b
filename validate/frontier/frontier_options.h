// Options of nlg-validate frontier: section `frontier` of pipeline.yaml.
#pragma once

#include "tool/command/options.h"
#include "validate/frontier/interleaved.h"
#include "validate/frontier/timed_policy.h"

namespace nlg {

struct FrontierOptions {
  int functions = 192;           // that take a theta
  double hard_tent_rmse = 0.01;  // functions whose bare tent is at least so wrong are hard
  InterleaveOptions interleave;
  // lists of rising whole numbers
  std::vector<std::string> lm_steps = {"4", "16", "64"};
  std::vector<std::string> adam_steps = {"200", "1000", "4000"};
  std::vector<std::string> direct_lm_steps = {"1", "2", "4", "8", "16", "32", "64"};
  std::vector<std::string> direct_adam_steps = {"125", "250", "500", "1000", "2000", "4000", "8000", "16000"};
  PolicyOptions policy;
  int bootstrap_draws = 1000;
  uint64_t seed = 1;

  // throws   UsageError naming the flag when a list is not one of rising whole numbers from 1 on
  FitBudgets budgets() const;
};

// Adds every option to the table of the section `frontier`, but those of the policy, which are describePolicy's.
void describe(FrontierOptions& options, OptionTable& table);

}  // namespace nlg
