#include "validate/errors/validate_options.h"

#include "tool/parallel_for.h"

namespace nlg {

int ValidateOptions::threadCount() const { return threads > 0 ? threads : machineThreadCount(); }

void describe(ValidateOptions& o, OptionTable& table) {
  table.group("Measurement");
  table.add("seed", &o.seed, "seed of random starts");
  describePolicy(o.policy, table);
  table.group("Measurement");
  table.add("theta_precision", &o.theta_precision, "float32, float16 or int8: what the light grid would store");
  table.add("hard_tent_rmse", &o.hard_tent_rmse, "hard functions: the bare tent's RMSE is at least this", 0.0, 1.0);
  table.add("direct_functions", &o.direct_functions,
            "the sample: functions that take a theta, evenly over scenes, on which long fits run", 1, 1000000);
  table.add("direct_adam_steps", &o.direct.adam_steps, "direct optimisation: Adam steps a start", 0, 10000000);
  table.add("direct_lm_iterations", &o.direct.levenberg_iterations, "direct optimisation: LM iterations a start", 0, 100000);
  table.add("direct_restarts", &o.direct.restarts, "direct optimisation: random starts", 1, 1000);
  table.add("convergence_functions", &o.convergence_functions,
            "hard functions of the sample on which direct optimisation is run with more and with less, to show that it has "
            "converged; 0: not shown",
            0, 100);
  table.add("threads", &o.threads, "threads; 0: as many as the machine runs at once. No error depends on them", 0, 1024);
}

}  // namespace nlg
