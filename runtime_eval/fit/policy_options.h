// The options of the policy (theta_policy.h). What each of them is, its default and its range stand in policy_options.def, and nowhere
// else: a field, a setting of the tools and a field of C have the name that is given there.
#pragma once

#include "runtime_eval/evaluator/representation.h"
#include "runtime_eval/support/loss_weights.h"

namespace nlg {

#define NLG_FIELD(type, name, value, low, high, help) type name = value;

// Whether a theta may stand for its function (function_check.h).
struct CheckOptions {
#define NLG_CHECK_OPTION NLG_FIELD
#include "runtime_eval/fit/policy_options.def"

  LossOptions loss() const { return {dark_weight, blend_floor}; }
};

// Which functions take which stages (stage_plan.h).
struct StageOptions {
#define NLG_STAGE_OPTION NLG_FIELD
#include "runtime_eval/fit/policy_options.def"
};

// How codes are fitted and how long they are (code_fit.h, code_rounding.h).
struct CodeOptions {
#define NLG_CODE_OPTION NLG_FIELD
#include "runtime_eval/fit/policy_options.def"
};

// What a theta takes that fails the check (refinement.h).
struct RefinementOptions {
#define NLG_REFINEMENT_OPTION NLG_FIELD
#include "runtime_eval/fit/policy_options.def"
};

// Which of several representations stands for a function (representation_choice.h).
struct ChoiceOptions {
#define NLG_CHOICE_OPTION NLG_FIELD
#include "runtime_eval/fit/policy_options.def"

  // The same choice on the errors of predicted theta, which have further to fall.
  ChoiceOptions forPredicted() const { return {choice_flat_ratio, choice_enough_rmse * choice_generator_excess, 1.0}; }
};

#undef NLG_FIELD

struct PolicyOptions : StageOptions, CodeOptions, CheckOptions, RefinementOptions, ChoiceOptions {
  ThetaPrecision theta_precision = ThetaPrecision::int8;  // what stored theta are rounded to, as a light grid holds them

  const CheckOptions& check() const { return *this; }
  CheckOptions& check() { return *this; }
};

// The name of the first option that is not finite or not in its range, "refine_first_steps"; null where all of them are. What the
// classes of this folder make of other options is not defined.
const char* outOfRange(const PolicyOptions& options);

}  // namespace nlg
