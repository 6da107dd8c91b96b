#include "bake/policy_options.h"

#include "tool/error.h"

namespace nlg {

void describePolicy(PolicyOptions& o, OptionTable& table) {
  table.add("bare_tent_rmse", &o.bare_tent_rmse,
            "a function that the bare tent gives with no larger an RMSE has no theta: its probe counts as free space; 0: every "
            "function has one",
            0.0, 1e3);
  table.add("good_rmse", &o.stages.good_rmse,
            "theta of the network whose RMSE is not above, and that pass the check, take no other stage; 0: none do", 0.0, 1e3);
  table.add("correct_steps", &o.stages.learned_steps, "corrections: learned steps of an attempt at most", 0, 64);
  table.add("correct_images", &o.stages.mirror_images, "networks: attempts at a function, itself and mirror images of it", 1, 8);
  table.add("retry_rmse", &o.stages.retry_rmse, "… another one, or another start, while its RMSE is above", 0.0, 1e3);
  table.add("fit_lm_iterations", &o.stages.lm_iterations,
            "short fits of product fields and small networks: iterations of Levenberg-Marquardt", 0, 1000);
  table.add("fit_lm_theta0_iterations", &o.stages.lm_theta0_iterations, "… and from theta0, where the RMSE is above retry_rmse",
            0, 1000);
  table.add("fit_adam_rmse", &o.stages.adam_rmse, "short fits of large networks: what is above after the corrections …", 0.0,
            1e3);
  table.add("fit_adam_steps", &o.stages.adam_steps, "… takes so many steps of Adam for each .01 of it, 4 times as many at most",
            0, 1000000);
  table.add("tau_rmse", &o.refinement.check.tau_rmse, "the check: a theta whose RMSE is above fails", 1e-6, 1.0);
  table.add("tau_leak", &o.refinement.check.tau_leak, "… weight that counts as a leak where the function is 0", 1e-6, 1.0);
  table.add("leak_share", &o.refinement.check.leak_share, "… a theta that leaks at a larger share of those points fails", 1e-6,
            1.0);
  table.add("refine_rounds", &o.refinement.rounds, "rounds of refinement of what fails, at most; 0: none", 0, 16);
  table.add("refine_first_steps", &o.refinement.first_steps, "steps of Adam in the first round", 1, 100000);
  table.add("refine_growth", &o.refinement.growth, "steps of a round over those of the round before", 1, 100);
  table.add("refine_leak_weight", &o.refinement.leak_weight, "weight of points where the function is 0", 1.0, 1e6);
  table.add("choice_flat_ratio", &o.choice.flat_ratio,
            "several weights: an error up to so many times that of a larger representation is no reason to take the larger", 1.0,
            1e6);
  table.add("choice_enough_rmse", &o.choice.enough_rmse,
            "several weights: an error of direct optimisation that needs no larger representation", 0.0, 1e3);
  table.add("choice_generator_excess", &o.choice.generator_excess,
            "errors of predicted theta are about so many times those of direct optimisation", 1.0, 1e3);
  table.renamed("correct_rmse", "good_rmse");
  table.renamed("correct_retry_rmse", "retry_rmse");
  table.renamed("correct_iterations", "fit_lm_iterations");
  table.renamed("correct_theta0_iterations", "fit_lm_theta0_iterations");
  table.renamed("correct_adam_rmse", "fit_adam_rmse");
  table.renamed("correct_adam_steps", "fit_adam_steps");
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
