// Writes frontier.json (keys: docs/reference/formats.md).
#pragma once

#include <nlohmann/json.hpp>

#include "validate/frontier/front.h"
#include "validate/frontier/plot_point.h"
#include "validate/frontier/point_figures.h"

namespace nlg {

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
