// Light grids of what functions are on their way into a grid: what a bake would store if it ended at the network, at corrections, or
// before rounding. With target φ before them and the bake's own grid behind them they say what each step costs in light.
#pragma once

#include <vector>

#include "bake/scene_functions.h"
#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

struct WordGrid {
  ThetaWord word = ThetaWord::network;
  LightGrid grid;  // without light, in the world's coordinates
};

// One grid for each word but `stored`, in their order. Probes and functions are those of the bake with this one generator.
// throws   as SceneFunctions does
std::vector<WordGrid> wordGrids(const BakeScene& scene, const Generator& generator, const BakeOptions& options, int thread_count);

}  // namespace nlg
