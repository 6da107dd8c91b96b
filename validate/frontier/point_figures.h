// The figures of a point: what its measurement comes to, over all functions and scene by scene.
#pragma once

#include <map>
#include <optional>

#include "validate/frontier/interleaved.h"

namespace nlg {

// A time's sample is the mean over the functions of one run on one block; median and quartiles are over these samples.
struct TimeFigures {
  double median_us = 0, p25_us = 0, p75_us = 0;
};

struct ErrorFigures {
  double mean = 0, median = 0, p5 = 0, p95 = 0, worst = 0;  // RMSE over functions
};

struct SceneFigures {
  TimeFigures time;  // samples: means over this scene's functions in one run on one block
  ErrorFigures rmse;
};

struct PointFigures {
  TimeFigures time;
  ErrorFigures rmse;
  std::optional<ErrorFigures> rmse_hard;  // over the hard functions alone, which decide what a bake looks like; none without any
  double leak_p99 = 0;                    // of |value| pooled over valid support points whose phi is 0
  std::map<std::string, SceneFigures> by_scene;
};

// The bare tent, which takes no time and no theta: what does not have a smaller error is on no front.
struct TentFigures {
  ErrorFigures rmse;
  std::optional<ErrorFigures> rmse_hard;
  std::map<std::string, ErrorFigures> by_scene;
};

// tent_rmse   by function, in the order of the blocks
TentFigures figuresOfTent(const std::vector<double>& tent_rmse, const std::vector<FunctionBlock>& blocks, const FunctionSet& set,
                          const std::vector<bool>& hard);

// hard    by function, in the order of the blocks
PointFigures figuresOf(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks, const FunctionSet& set,
                       const std::vector<bool>& hard);

}  // namespace nlg
