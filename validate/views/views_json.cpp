#include "validate/views/views_json.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "render/panel.h"
#include "render/picture/legend.h"
#include "render/tone.h"

namespace nlg {
namespace {

Image enlarged(const Image& image, int scale) {
  Image large(image.width() * scale, image.height() * scale, kBlack);
  for (int y = 0; y < large.height(); ++y) {
    for (int x = 0; x < large.width(); ++x) large.set(x, y, image.at(x / scale, y / scale));
  }
  return large;
}

std::vector<std::string> captionOf(const ViewFigures& f) {
  return {fmt::format("HyAB {:.1f}, > 2x {:.1f} %", f.colour, 100.0 * (f.off.brighter + f.off.darker))};
}

using Json = nlohmann::ordered_json;

Json vectorJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json figuresJson(const ViewFigures& f) {
  return {{"receivers", f.receivers},
          {"hyab", f.colour},
          {"energy", f.energy},
          {"off_2", {{"brighter", f.off.brighter}, {"darker", f.off.darker}}},
          {"below_eighth", f.below_eighth},
          {"ringing", f.ringing}};
}

Json byClassJson(const std::string& weights, const std::string& light, const ViewFiguresByClass& figures) {
  Json json = {{"weights", weights}, {"light", light}};
  for (size_t c = 0; c < kViewClassCount; ++c) {
    if (figures[c].receivers > 0) json[kViewClassNames[c]] = figuresJson(figures[c]);
  }
  return json;
}

}  // namespace

Image viewRow(const std::vector<ShownMethod>& methods, double exposure, const std::vector<std::string>& truth_caption,
              int scale) {
  std::vector<PanelColumn> columns;
  for (size_t m = 0; m < methods.size(); ++m) {
    const std::vector<std::string> caption = m == 0 ? truth_caption : captionOf(methods[m].figures);
    columns.push_back({methods[m].picture.method, caption, enlarged(toneMapped(methods[m].picture, exposure), scale), {}});
  }
  return drawPanel(columns, {});
}

Image contactSheet(const std::vector<Image>& rows, const std::string& heading) {
  constexpr int kMargin = 16, kScale = 2, kHead = kScale * kGlyphHeight + kMargin;
  int width = textWidth(heading, kScale) + 2 * kMargin, height = kMargin + kHead;
  for (const Image& row : rows) {
    width = std::max(width, row.width());
    height += row.height();
  }
  Image sheet(width, height, kPaper);
  drawText(sheet, kMargin, kMargin, heading, kInk, kScale);
  int y = kMargin + kHead;
  for (const Image& row : rows) {
    paste(sheet, row, 0, y);
    y += row.height();
  }
  return sheet;
}

Json viewJson(const SceneView& view, const ViewTruth& truth, const std::vector<MeasuredViews>& methods, size_t number,
              const glm::dvec3& origin_m) {
  const glm::dvec3 eye = origin_m + view.camera.eye_m;
  Json json = {{"room", view.room},
               {"has_roof", view.has_roof},
               {"eye_m", vectorJson(eye)},
               {"look_m", vectorJson(eye + glm::dvec3(view.camera.forward))},
               {"fov_degrees", view.camera.fov_y * 180.0 / std::numbers::pi},
               {"figure_m", view.figure.empty() ? Json() : vectorJson(origin_m + view.figure.front().centre_m)},
               {"exposure", truth.exposure},
               {"truth",
                {{"median", truth.median},
                 {"noise", truth.noise},
                 {"noise_median", truth.median_noise},
                 {"hyab_noise", truth.colour_noise},
                 {"is_known", truth.isKnown()},
                 {"is_lit", truth.isLit()}}},
               {"methods", Json::array()}};
  for (const MeasuredViews& method : methods)
    json["methods"].push_back(byClassJson(method.weights, method.light, method.views[number]));
  return json;
}

Json methodsJson(const std::vector<MeasuredViews>& methods) {
  Json json = Json::array();
  for (const MeasuredViews& method : methods)
    json.push_back(byClassJson(method.weights, method.light, meanFigures(method.views)));
  return json;
}

std::string viewsTable(const std::string& scene, const std::vector<MeasuredViews>& methods, double colour_noise) {
  const auto off = [](const ViewFigures& f) { return 100.0 * (f.off.brighter + f.off.darker); };
  std::string table = fmt::format("{:<18} {:<48} {:>6} {:>6} {:>8} {:>8} {:>12} {:>10}\n", "scene", "method", "HyAB", "energy",
                                  "> 2x, %", "< 1/8, %", "edges > 2x, %", "ringing, %");
  for (const MeasuredViews& method : methods) {
    const ViewFiguresByClass mean = meanFigures(method.views);
    const ViewFigures &all = mean[static_cast<size_t>(ViewClass::all)], &edge = mean[static_cast<size_t>(ViewClass::edge)];
    table += fmt::format("{:<18} {:<48} {:>6.2f} {:>6.2f} {:>8.2f} {:>8.2f} {:>13.2f} {:>10.3f}\n", scene,
                         method.weights + ", " + method.light, all.colour, all.energy, off(all), 100.0 * all.below_eighth,
                         off(edge), 100.0 * all.ringing);
  }
  return table + fmt::format("{:<18} {:<48} {:>6.2f}\n", scene, "(noise of truth)", colour_noise);
}

}  // namespace nlg
