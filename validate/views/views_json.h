// views.json: keys and meanings in docs/reference/formats.md.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "validate/views/scene_views.h"
#include "validate/views/view_figures.h"

namespace nlg {

// What a method made of views.
struct MeasuredViews {
  std::string weights, light;  // as LightMethod has them
  std::vector<ViewFiguresByClass> views;
};

// view       by number, from 0
// origin_m   of the scene: positions are the world's
nlohmann::ordered_json viewJson(const SceneView& view, const ViewTruth& truth, const std::vector<MeasuredViews>& methods,
                                size_t number, const glm::dvec3& origin_m);

// Means over views.
nlohmann::ordered_json methodsJson(const std::vector<MeasuredViews>& methods);

// Lines for a terminal: what of the means one looks at first.
// colour_noise   of truth, the mean over views: no method can be seen to be nearer
std::string viewsTable(const std::string& scene, const std::vector<MeasuredViews>& methods, double colour_noise);

}  // namespace nlg
