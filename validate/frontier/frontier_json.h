// Writes frontier.json (keys: docs/reference/formats.md).
#pragma once

#include <map>

#include <nlohmann/json.hpp>

#include "validate/frontier/front.h"
#include "validate/frontier/interleaved.h"

namespace nlg {

// Figures of a point's measurement, by population and scene by scene.

// A time's sample is the mean over the functions of one run on one block; median and quartiles are over these samples.
struct TimeFigures {
  double median_us = 0, p25_us = 0, p75_us = 0;
};

// Blend RMSE over functions.
struct ErrorFigures {
  double mean = 0, median = 0, p5 = 0, p95 = 0, worst = 0;
};

// Over the functions of a population, or of a scene.
struct FrontierFigures {
  TimeFigures time;  // samples: means over these functions in one run on one block
  ErrorFigures blend_rmse;
  double rmse_mean = 0;  // of the plain RMSE, which is shown and not judged
};

struct PopulationFigures : FrontierFigures {
  double leak_p99 = 0;  // of |value| pooled over the points that count as leaks
  double share_failing_check = 0, share_fitted = 0;
};

struct PointFigures {
  std::map<Population, PopulationFigures> figures;  // of those that hold functions
  std::map<std::string, FrontierFigures> by_scene;
};

// Mean blend RMSE of the bare tent, which takes no time and no theta: what does not have a smaller error is on no front.
struct TentFigures {
  std::map<Population, double> figures;
  std::map<std::string, double> by_scene;
};

TentFigures figuresOfTent(const FunctionSet& set, const ChosenFunctions& functions, const LossOptions& loss);

PointFigures figuresOf(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                       const std::vector<FunctionBlock>& blocks);

// The time of every function that takes a theta, the median of its runs, µs.
std::vector<double> functionTimes(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks);

// The front of one population.
struct Front {
  std::vector<bool> members;  // by point
  std::string sentence;
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
  std::map<Population, Front> fronts;  // of median time and mean blend RMSE
  std::vector<WordSpeed> speeds;
};

// Finds the fronts and says what they are. The speeds are left empty.
FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, TentFigures tent);

// The keys points, bare_tent, front_sentences and speed_at_equal_error.
nlohmann::ordered_json pointsJson(const FrontierResult& result);

}  // namespace nlg
