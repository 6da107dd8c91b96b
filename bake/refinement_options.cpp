#include "bake/refinement_options.h"

namespace nlg {

void describeCorrection(CorrectionOptions& o, OptionTable& table) {
  table.add("correct_rmse", &o.correct_rmse,
            "predicted theta whose RMSE is above are corrected, as are those that fail the check; 0: all", 0.0, 1e3);
  table.add("correct_steps", &o.most_steps, "learned correction steps of an attempt at most", 0, 64);
  table.add("correct_images", &o.mirror_images, "networks: attempts at a function, itself and mirror images of it", 1, 8);
  table.add("correct_retry_rmse", &o.retry_rmse, "… another one while its RMSE is above", 0.0, 1e3);
  table.add("correct_adam_rmse", &o.adam_rmse, "large networks: what is above after all that …", 0.0, 1e3);
  table.add("correct_adam_steps", &o.adam_steps, "… takes so many steps of Adam", 0, 1000000);
  table.add("correct_iterations", &o.iterations,
            "product fields, small networks: iterations of Levenberg-Marquardt after the steps", 0, 1000);
  table.add("correct_theta0_iterations", &o.theta0_iterations, "… and from theta_0, where the RMSE is above correct_retry_rmse",
            0, 1000);
}

void describeRefinement(RefinementOptions& o, OptionTable& table) {
  table.add("tau_rmse", &o.check.tau_rmse, "a theta whose RMSE is above needs refinement", 1e-6, 1.0);
  table.add("tau_leak", &o.check.tau_leak, "weight that counts as a leak where the function is 0", 1e-6, 1.0);
  table.add("leak_share", &o.check.leak_share, "a theta that leaks at a larger share of those points needs refinement", 1e-6,
            1.0);
  table.add("refine_rounds", &o.rounds, "rounds of refinement at most; 0: none", 0, 16);
  table.add("refine_first_steps", &o.first_steps, "steps of Adam in the first round", 1, 100000);
  table.add("refine_growth", &o.growth, "steps of a round over those of the round before", 1, 100);
  table.add("refine_leak_weight", &o.leak_weight, "weight of points where the function is 0", 1.0, 1e6);
}

void describeChoice(ChoiceOptions& o, OptionTable& table) {
  table.add("choice_flat_ratio", &o.flat_ratio,
            "several weights: an error up to so many times that of a larger representation is no reason to take the larger", 1.0,
            1e6);
  table.add("choice_enough_rmse", &o.enough_rmse,
            "several weights: an error of direct optimisation that needs no larger representation", 0.0, 1e3);
  table.add("choice_generator_excess", &o.generator_excess,
            "generated errors are about so many times those of direct optimisation", 1.0, 1e3);
}

}  // namespace nlg
