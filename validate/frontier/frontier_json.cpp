#include "validate/frontier/frontier_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <fstream>

#include "tool/error.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

void addFigures(const TimeFigures& time, const ErrorFigures& rmse, Json& json) {
  json["us_median"] = time.median_us;
  json["us_p25"] = time.p25_us;
  json["us_p75"] = time.p75_us;
  json["rmse_mean"] = rmse.mean;
  json["rmse_median"] = rmse.median;
  json["rmse_p5"] = rmse.p5;
  json["rmse_p95"] = rmse.p95;
  json["rmse_worst"] = rmse.worst;
}

Json pointJson(const PlotPoint& point, const PointFigures& figures, bool on_front) {
  Json json = {{"representation", point.representation}, {"family", point.family}};
  json["budget"] = point.budget ? Json(*point.budget) : Json(nullptr);
  json["label"] = point.label;
  addFigures(figures.time, figures.rmse, json);
  json["leak_p99"] = figures.leak_p99;
  json["on_front"] = on_front;
  json["by_scene"] = Json::object();
  for (const auto& [scene, of_scene] : figures.by_scene) addFigures(of_scene.time, of_scene.rmse, json["by_scene"][scene]);
  return json;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

std::string csvFigures(const TimeFigures& time, const ErrorFigures& rmse) {
  return fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", time.median_us, time.p25_us, time.p75_us,
                     rmse.mean, rmse.median, rmse.p5, rmse.p95, rmse.worst);
}

Json readHierarchy(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) throw InputError(path, "file", "one that can be read", "none");
  const Json json = Json::parse(stream, nullptr, false);
  if (json.is_discarded() || !json.is_object() || json.value("schema_version", 0) != 1 || !json.contains("hierarchy") ||
      !json.contains("walks") || !json["hierarchy"].is_array() || !json["walks"].is_array()) {
    throw InputError(path, "content", "a SCENE.hierarchy.json of nlg-solve, schema_version 1", "something else");
  }
  return json;
}

// Puts a scene's entry under the step of the same name and representation.
void addStep(const std::string& path, const Json& entry, Json& steps) {
  if (!entry.is_object() || !entry.contains("step") || !entry.contains("representation") || !entry.contains("scene") ||
      !entry["scene"].is_string()) {
    throw InputError(path, "hierarchy", "entries with step, representation and scene", entry.dump());
  }
  const auto same = [&](const Json& step) {
    return step["step"] == entry["step"] && step["representation"] == entry["representation"];
  };
  auto found = std::find_if(steps.begin(), steps.end(), same);
  if (found == steps.end()) {
    steps.push_back({{"step", entry["step"]}, {"representation", entry["representation"]}});
    found = std::prev(steps.end());
  }
  Json figures = Json::object();
  for (const auto& [key, value] : entry.items()) {
    if (key != "step" && key != "representation" && key != "scene") figures[key] = value;
  }
  (*found)["by_scene"][entry["scene"].get<std::string>()] = figures;
}

// Every figure's mean over the scenes; null where a scene has none.
void meanOverScenes(Json& step) {
  const Json by_scene = step["by_scene"];
  step.erase("by_scene");
  for (const auto& [key, value] : by_scene.front().items()) {
    double sum = 0.0;
    bool is_number = true;
    for (const Json& figures : by_scene) {
      is_number &= figures.contains(key) && figures[key].is_number();
      if (is_number) sum += figures[key].get<double>();
    }
    step[key] = is_number ? Json(sum / static_cast<double>(by_scene.size())) : Json(nullptr);
  }
  step["by_scene"] = by_scene;
}

}  // namespace

FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, const FrontTolerances& tolerances) {
  std::vector<FrontPoint> front;
  std::vector<std::string> names;
  for (size_t p = 0; p < points.size(); ++p) {
    front.push_back({figures[p].time.median_us, figures[p].rmse.median, points[p].may_be_on_front});
    names.push_back(points[p].representation + ": " + points[p].label);
  }
  std::vector<bool> members = frontMembers(front, tolerances);
  std::string sentence = frontSentence(front, members, names);
  return {std::move(points), std::move(figures), std::move(members), std::move(sentence)};
}

Json pointsJson(const FrontierResult& result) {
  Json json = {{"points", Json::array()}};
  for (size_t p = 0; p < result.points.size(); ++p) {
    json["points"].push_back(pointJson(result.points[p], result.figures[p], result.on_front[p]));
  }
  json["front_sentence"] = result.front_sentence;
  return json;
}

std::string pointsCsv(const FrontierResult& result) {
  std::string csv =
      "representation,family,budget,label,us_median,us_p25,us_p75,rmse_mean,rmse_median,rmse_p5,rmse_p95,rmse_worst,"
      "leak_p99,on_front\n";
  for (size_t p = 0; p < result.points.size(); ++p) {
    const PlotPoint& point = result.points[p];
    const PointFigures& figures = result.figures[p];
    const std::string budget = point.budget ? fmt::format("{}", *point.budget) : "";
    csv += fmt::format("{},{},{},{},{},{:.6g},{}\n", point.representation, point.family, budget, quoted(point.label),
                       csvFigures(figures.time, figures.rmse), figures.leak_p99, result.on_front[p] ? 1 : 0);
  }
  return csv;
}

void addHierarchies(const std::vector<std::string>& paths, Json& frontier) {
  Json& hierarchy = frontier["hierarchy"] = Json::array();
  Json walks = Json::array();
  for (const std::string& path : paths) {
    const Json scene = readHierarchy(path);
    for (const Json& entry : scene["hierarchy"]) addStep(path, entry, hierarchy);
    for (const Json& entry : scene["walks"]) walks.push_back(entry);
  }
  for (Json& step : hierarchy) meanOverScenes(step);
  frontier["walks"] = std::move(walks);
}

}  // namespace nlg
