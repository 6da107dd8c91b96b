// Writes frontier.json (keys: docs/reference/formats.md).
#pragma once

#include <array>
#include <map>
#include <optional>

#include <nlohmann/json.hpp>

#include "validate/frontier/front.h"
#include "validate/frontier/interleaved.h"

namespace nlg {

// Figures of a point's measurement, by population and scene by scene.

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

// The front of one population.
struct Front {
  std::vector<bool> members;  // by point
  std::string sentence;       // empty when the population is
};

// One word of one representation against its direct fits.
struct WordSpeed {
  std::string representation;
  ThetaWord word = ThetaWord::network;
  EqualError equal;
};

struct FrontierResult {
  std::vector<PlotPoint> points;
  std::vector<PointFigures> figures;  // by point
  TentFigures tent;
  std::array<Front, kPopulationCount> fronts;  // of median time and mean blend RMSE
  std::vector<WordSpeed> speeds, speeds_hard;  // over functions that take a theta, and over the hard ones
};

// Finds the fronts and says what they are. The speeds are left empty.
FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, TentFigures tent,
                          const FrontTolerances& tolerances);

// The keys points, bare_tent, front_sentences, speed_at_equal_error and speed_at_equal_error_hard.
nlohmann::ordered_json pointsJson(const FrontierResult& result);

}  // namespace nlg
