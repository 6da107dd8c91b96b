// The held-out functions that a generator does worst, as points of a plane through each: for pictures while it trains.
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "train/generator/run/trainer.h"

namespace nlg {

struct WorstFunction {
  struct Point {
    float u = 0.0f, v = 0.0f;  // along the axes behind `axis`, in [-1, 1]
    float target = 0.0f, predicted = 0.0f;
  };
  uint32_t function = 0;  // of the held-out set
  double blend_rmse = 0.0;
  int axis = 1;               // that the plane is normal to, of those through the probe the one where both differ most
  std::vector<Point> points;  // valid support points near the plane
};

// Of at most 256 functions that take a theta, at equal distances; the worst first, at most `count`. Each by the better of its stages.
std::vector<WorstFunction> worstFunctions(GeneratorNetwork& network, const Representation& representation,
                                          const TrainingData& held_out, const TrainOptions& options, size_t count);

// {"step", "functions": [{"function", "blend_rmse", "axis", "points": [[u, v, target, predicted], …]}, …]}
nlohmann::ordered_json worstFunctionsJson(int64_t step, const std::vector<WorstFunction>& worst);

}  // namespace nlg
