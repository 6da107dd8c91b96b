// Bakes one scene into a light grid: weighting functions, the policy, light.
#pragma once

#include <string>
#include <vector>

#include "bake/blend_error.h"
#include "bake/light_bake.h"
#include "bake/scene_functions.h"

namespace nlg {

// What a tree had before cells without air were left out.
struct AirStatistics {
  uint64_t cells = 0, airless_cells = 0;
  uint64_t probes = 0;                  // before
  uint64_t drawn = 0, in_cavities = 0;  // places, and those of them that are no air because they lie in cavities (cavity.h)
  double wall_s = 0.0;                  // to find the air
};

// What became of one function that has theta.
struct FunctionOutcome {
  ThetaRecord record;
  uint8_t generator = 0;  // of the representation that was chosen
  bool raised = false;    // refinement took a larger representation than the choice
};

// The talk's columns and what else a bake can say of itself. Seconds by the clock, those of stages summed over threads.
struct BakeStatistics {
  ShardCounts counts;
  FunctionTimes function_times;
  AirStatistics air;
  LightStatistics light;
  double wall_s = 0.0, load_wall_s = 0.0, functions_wall_s = 0.0,
         refinement_wall_s = 0.0;  // functions: stages up to fits included
  uint64_t left_for_time = 0;      // functions that failed the check and were not refined: refine_seconds were over
  TentCounts bare_tents;           // functions without theta: not in the list below
  std::vector<FunctionOutcome> functions;
  BlendErrors blend;  // of the grid as it is

  double stageSeconds(ThetaStage stage) const;
  // Of the stages that bring theta to a word, of all representations; without checks and without refinement.
  double wordSeconds(ThetaWord word) const;
  // Functions whose theta fails the check at a word.
  uint64_t failing(ThetaWord word, const CheckOptions& check) const;
  uint64_t tookFit() const;
  uint64_t refined() const;
  uint64_t raised() const;
  // Functions by representation, in the order of the generators.
  std::vector<uint64_t> chosen(size_t generator_count) const;
};

struct Bake {
  LightGrid grid;
  BakeStatistics statistics;
  FunctionRows failed;  // whose stored theta fails the check, the worst first: rows of a shard
};

// generators     one a representation, by rising D; at least one
// metadata       that the file is going to have: max_bytes counts it
// collect_count  `failed` holds at most so many functions
// throws         as SceneFunctions does
Bake bakeScene(const PreparedScene& scene, const std::vector<Generator>& generators, const BakeOptions& options,
               const std::string& spool_folder, const GridMetadata& metadata = {}, uint64_t collect_count = 0);

}  // namespace nlg
