// Figures of a point's measurement, by population and scene by scene.
#pragma once

#include <array>
#include <map>
#include <optional>

#include "validate/frontier/interleaved.h"

namespace nlg {

// A time's sample is the mean over the functions of one run on one block; median and quartiles are over these samples.
struct TimeFigures {
  double median_us = 0, p25_us = 0, p75_us = 0;
};

// Over functions.
struct ErrorFigures {
  double mean = 0, median = 0, p5 = 0, p95 = 0, worst = 0;
};

// What is judged, and what stands beside it.
struct BothErrors {
  ErrorFigures blend_rmse, rmse;
};

struct SceneFigures {
  TimeFigures time;  // samples: means over this scene's functions in one run on one block
  BothErrors errors;
};

struct PopulationFigures {
  TimeFigures time;
  BothErrors errors;
  double leak_p99 = 0;  // of |value| pooled over the points that count as leaks
  double share_failing_check = 0, share_fitted = 0;
};

// By Population; none where it is empty.
template <class Figures>
using ByPopulation = std::array<std::optional<Figures>, kPopulationCount>;

struct PointFigures {
  ByPopulation<PopulationFigures> figures;
  std::map<std::string, SceneFigures> by_scene;  // of functions that take a theta
};

// The bare tent, which takes no time and no theta: what does not have a smaller error is on no front.
struct TentFigures {
  ByPopulation<BothErrors> figures;
  std::map<std::string, BothErrors> by_scene;  // of functions that take a theta
};

struct BareTents {
  std::vector<FunctionError> with_theta;  // of the functions that take one
  // of those that take none, all of which pass the check: what they have in every point's figures over all functions
  std::vector<double> blend_rmse, rmse;
  PooledMagnitudes leaks;
};
BareTents measureBareTents(const FunctionSet& set, const ChosenFunctions& functions, const LossOptions& loss);

TentFigures figuresOfTent(const FunctionSet& set, const ChosenFunctions& functions, const BareTents& tents);

PointFigures figuresOf(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                       const std::vector<FunctionBlock>& blocks, const BareTents& tents);

// The time of every function that takes a theta, the median of its runs, µs.
std::vector<double> functionTimes(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks);

}  // namespace nlg
