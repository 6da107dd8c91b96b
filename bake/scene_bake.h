// The bake of one scene without light: functions, generators, check, refinement → a light grid.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bake/bake_savings.h"
#include "bake/scene_functions.h"
#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/fit_result.h"
#include "runtime_eval/light_grid/light_grid_file.h"

namespace nlg {

// The talk's columns and what else a bake can say of itself. Seconds of stages are by the clock, summed over threads.
struct BakeStatistics {
  ShardCounts counts;
  FunctionTimes function_times;
  double generator_s = 0.0, check_s = 0.0, correction_s = 0.0, refinement_s = 0.0;
  double wall_s = 0.0, load_wall_s = 0.0, functions_wall_s = 0.0, refinement_wall_s = 0.0;  // functions: generators included
  uint64_t corrected = 0;           // predicted theta that corrections replaced, of all representations
  uint64_t checked = 0, right = 0;  // predicted theta, of all representations; those that need no correction
  uint64_t smallest_enough = 0;     // functions for which no larger generator ran
  uint64_t failed_check = 0;        // functions whose theta failed, corrected or not
  uint64_t refined = 0;             // of these were refined
  uint64_t left_for_time = 0;       // were not: refine_seconds were over
  uint64_t still_failing = 0;       // functions whose theta in the grid fails the check
  std::array<uint64_t, kFitStopCount> refinement_stops{};  // how the last fits of refinements ended, by FitStop
  uint64_t raised = 0;           // refined functions that ended with a larger representation than was chosen first
  std::vector<uint64_t> chosen;  // functions by representation, in the order of the generators
  std::vector<FunctionCheck> generated, stored;  // by function: after generator and correction, and of what the grid holds
  BareTents bare_tents;                          // functions without theta: in none of the counts of functions
  std::vector<uint8_t> tent_passes;              // by function: whether the bare tent passes the check
};

// What storing theta in fewer bits changed, over all functions: RMSE after rounding minus RMSE before.
struct RoundingError {
  double mean_rmse_added = 0.0, worst_rmse_added = 0.0;
};

struct Bake {
  LightGrid grid;
  RoundingError rounding;
  BakeStatistics statistics;
};

// generators        one a representation, by rising D; at least one
// theta_precision   theta of the grid are rounded to it
// savings           what is left out
// throws            as SceneFunctions does; NumericalError when a theta is beyond float16
Bake bakeScene(const BakeScene& scene, const std::vector<Generator>& generators, const BakeOptions& options,
               ThetaPrecision theta_precision, const std::string& spool_folder, const BakeSavings& savings = {});

}  // namespace nlg
