// frontier.json and frontier.csv from the figures; keys and columns: docs/reference/formats.md.
#pragma once

#include <nlohmann/json.hpp>

#include "validate/frontier/front.h"
#include "validate/frontier/plot_point.h"
#include "validate/frontier/point_figures.h"

namespace nlg {

// What is written of all points, in their order.
struct Front {
  std::vector<bool> members;  // by point
  std::string sentence;       // names them; empty when there is no front
};

struct FrontierResult {
  std::vector<PlotPoint> points;
  std::vector<PointFigures> figures;  // by point
  TentFigures tent;
  Front all, hard;  // of the median error over all functions, and over the hard ones
};

// Finds the fronts and says who is on them.
FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, TentFigures tent,
                          const FrontTolerances& tolerances);

// The keys points, bare_tent, front_sentence and hard_front_sentence.
nlohmann::ordered_json pointsJson(const FrontierResult& result);

// One row a point, over all functions.
std::string pointsCsv(const FrontierResult& result);

// The lists hierarchy and walks, means over the scenes, out of the files that nlg-solve --weights writes, one a scene; both empty
// without any.
// throws   InputError when a file is not one
void addHierarchies(const std::vector<std::string>& paths, nlohmann::ordered_json& frontier);

}  // namespace nlg
