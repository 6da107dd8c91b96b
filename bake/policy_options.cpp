#include "bake/policy_options.h"

#include "runtime_eval/fit/policy_ranges.h"
#include "tool/error.h"

namespace nlg {

void describePolicy(PolicyOptions& o, OptionTable& table) {
  const PolicyRanges& range = kPolicyRanges;
  table.group("Policy: which theta are worked on, and how long");
  const auto add = [&](const char* name, auto* value, const char* help, const auto& may) {
    table.add(name, value, help, may.low, may.high);
  };
  add("bare_tent_rmse", &o.bare_tent_rmse,
      "a function that the bare tent gives with no larger an RMSE has no theta: its probe counts as free space; 0: every "
      "function has one",
      range.rmse);
  add("good_rmse", &o.stages.good_rmse,
      "theta of the network whose RMSE is not above, and that pass the check, take no other stage; 0: none do", range.rmse);
  add("correct_steps", &o.stages.learned_steps, "corrections: learned steps of an attempt at most", range.learned_steps);
  add("correct_images", &o.stages.mirror_images, "networks: attempts at a function, itself and mirror images of it",
      range.mirror_images);
  add("retry_rmse", &o.stages.retry_rmse, "… another one, or another start, while its RMSE is above", range.rmse);
  add("fit_lm_iterations", &o.stages.lm_iterations, "short fits of product fields: iterations of Levenberg-Marquardt",
      range.lm_iterations);
  add("fit_lm_theta0_iterations", &o.stages.lm_theta0_iterations, "… and from theta0, where the RMSE is above retry_rmse",
      range.lm_iterations);
  add("fit_adam_rmse", &o.stages.adam_rmse, "short fits of networks: what is above after the corrections …", range.rmse);
  add("fit_adam_steps", &o.stages.adam_steps, "… takes so many steps of Adam for each .01 of it, 4 times as many at most",
      range.adam_steps);
  add("tau_rmse", &o.refinement.check.tau_rmse, "the check: a theta whose RMSE is above fails", range.tau);
  add("tau_leak", &o.refinement.check.tau_leak, "… weight that counts as a leak where the function is 0", range.tau);
  add("leak_share", &o.refinement.check.leak_share, "… a theta that leaks at a larger share of those points fails", range.tau);
  add("refine_rounds", &o.refinement.rounds, "rounds of refinement of what fails, at most; 0: none", range.refine_rounds);
  add("refine_first_steps", &o.refinement.first_steps, "steps of Adam in the first round", range.refine_first_steps);
  add("refine_growth", &o.refinement.growth, "steps of a round over those of the round before", range.refine_growth);
  add("refine_leak_weight", &o.refinement.leak_weight, "weight of points where the function is 0", range.refine_leak_weight);
  add("choice_flat_ratio", &o.choice.flat_ratio,
      "several weights: an error up to so many times that of a larger representation is no reason to take the larger",
      range.flat_ratio);
  add("choice_enough_rmse", &o.choice.enough_rmse,
      "several weights: an error of direct optimisation that needs no larger representation", range.rmse);
  add("choice_generator_excess", &o.choice.generator_excess,
      "errors of predicted theta are about so many times those of direct optimisation", range.generator_excess);
}

PolicyOptions defaultBakePolicy() {
  PolicyOptions options;
  options.theta_precision = thetaPrecisionFromName(kDefaultThetaPrecision);
  return options;
}

ThetaPrecision thetaPrecisionFromName(const std::string& name) {
  if (name == "float32") return ThetaPrecision::float32;
  if (name == "float16") return ThetaPrecision::float16;
  if (name == "int8") return ThetaPrecision::int8;
  throw UsageError("theta_precision", "float32, float16 or int8", "'" + name + "'");
}

std::string stagesHelp(const PolicyOptions& options) {
  std::string text =
      "Stages of the policy, by representation (thresholds rise for weights that are wrong about the tent itself: "
      "docs/theory/math.md §6):\n";
  for (const char* name : kRepresentationNames) {
    Representation representation;
    findRepresentation(name, &representation);
    const bool linear = !representation.isField() && representation.shape().output == OutputFunction::linear;
    text += std::string("  ") + name + '\n';
    for (const StagePlan& plan : stagesOf({representation, linear, true, 0.0}, options)) text += "    " + describe(plan) + '\n';
  }
  return text;
}

}  // namespace nlg
