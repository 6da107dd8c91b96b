// Writes views.json (keys: docs/reference/formats.md), and pictures for people.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "render/lit_picture.h"
#include "render/picture/image.h"
#include "validate/views/scene_views.h"
#include "validate/views/view_figures.h"

namespace nlg {

// Of one view, by one method.
struct ShownMethod {
  LitPicture picture;   // its method is the title
  ViewFigures figures;  // none are written below truth
};

// Each pixel of the pictures becomes a square of scale x scale.
// methods         truth first
// truth_caption   lines below truth
Image viewRow(const std::vector<ShownMethod>& methods, double exposure, const std::vector<std::string>& truth_caption, int scale);

// Rows below one another.
Image contactSheet(const std::vector<Image>& rows, const std::string& heading);

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
