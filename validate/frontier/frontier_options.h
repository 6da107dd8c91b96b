// The settings of nlg-validate frontier: section `frontier` of pipeline.yaml.
#pragma once

#include "tool/options.h"
#include "validate/frontier/choice_point.h"
#include "validate/frontier/fit_points.h"
#include "validate/frontier/front.h"
#include "validate/frontier/interleaved.h"

namespace nlg {

struct FrontierOptions {
  int functions = 192;
  double hard_tent_rmse = 0.01;  // functions whose bare tent is at least so wrong are hard
  InterleaveOptions interleave;
  // lists of rising whole numbers
  std::vector<std::string> lm_steps = {"1", "2", "4", "8", "16", "32", "64"};
  std::vector<std::string> adam_steps = {"16", "50", "200", "1000"};
  std::vector<std::string> direct_lm_steps = {"4", "16", "64", "256"};
  std::vector<std::string> direct_adam_steps = {"250", "1000", "4000", "16000"};
  std::vector<std::string> coefficients;  // empty: powers of two from 32, and all
  CorrectionOptions correction;
  CheckOptions check;
  ChoiceOptions choice;
  FrontTolerances front;
  uint64_t seed = 1;

  // throws   UsageError naming the flag when a list is not one of rising whole numbers from 1 on
  FitBudgets budgets() const;
  std::vector<int> coefficientCounts() const;
};

// Adds every option to the table of the section `frontier`.
void describe(FrontierOptions& options, OptionTable& table);

}  // namespace nlg
