// frontier.json and frontier.csv from the figures; keys and columns: docs/formats.md.
#pragma once

#include <nlohmann/json.hpp>

#include "validate/frontier/front.h"
#include "validate/frontier/plot_point.h"
#include "validate/frontier/point_figures.h"

namespace nlg {

// What is written of all points, in their order.
struct FrontierResult {
  std::vector<PlotPoint> points;
  std::vector<PointFigures> figures;  // by point
  std::vector<bool> on_front;         // by point
  std::string front_sentence;
};

// Finds the front and says who is on it.
FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, const FrontTolerances& tolerances);

// The keys points and front_sentence.
nlohmann::ordered_json pointsJson(const FrontierResult& result);

// One row a point, over all functions.
std::string pointsCsv(const FrontierResult& result);

// The lists hierarchy and walks, means over the scenes, out of the files that nlg-solve --weights writes, one a scene; both empty
// without any.
// throws   InputError when a file is not one
void addHierarchies(const std::vector<std::string>& paths, nlohmann::ordered_json& frontier);

}  // namespace nlg
