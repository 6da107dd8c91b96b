#include "validate/frontier/frontier_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <fstream>

#include "tool/error.h"
#include "validate/errors/csv_field.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

void addErrors(const ErrorFigures& rmse, Json& json) {
  json["rmse_mean"] = rmse.mean;
  json["rmse_median"] = rmse.median;
  json["rmse_p5"] = rmse.p5;
  json["rmse_p95"] = rmse.p95;
  json["rmse_worst"] = rmse.worst;
}

void addFigures(const TimeFigures& time, const ErrorFigures& rmse, Json& json) {
  json["us_median"] = time.median_us;
  json["us_p25"] = time.p25_us;
  json["us_p75"] = time.p75_us;
  addErrors(rmse, json);
}

Json pointJson(const PlotPoint& point, const PointFigures& figures, bool on_front, bool on_hard_front) {
  Json json = {{"representation", point.representation}, {"family", point.family}};
  json["budget"] = point.budget ? Json(*point.budget) : Json(nullptr);
  json["label"] = point.label;
  addFigures(figures.time, figures.rmse, json);
  json["leak_p99"] = figures.leak_p99;
  json["on_front"] = on_front;
  json["hard"] = nullptr;
  if (figures.rmse_hard) {
    json["hard"] = {{"on_front", on_hard_front}};
    addErrors(*figures.rmse_hard, json["hard"]);
  }
  json["by_scene"] = Json::object();
  for (const auto& [scene, of_scene] : figures.by_scene) addFigures(of_scene.time, of_scene.rmse, json["by_scene"][scene]);
  return json;
}

std::string csvErrors(const ErrorFigures& rmse) {
  return fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", rmse.mean, rmse.median, rmse.p5, rmse.p95, rmse.worst);
}

std::string csvFigures(const TimeFigures& time, const ErrorFigures& rmse) {
  return fmt::format("{:.6g},{:.6g},{:.6g},{}", time.median_us, time.p25_us, time.p75_us, csvErrors(rmse));
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

// What several scenes say of one step or walk: a flat row that a table shows as it is.
struct SceneMean {
  const char* name_key;  // "step" or "functions"
  Json rows = Json::array();
  std::vector<std::vector<Json>> entries;  // by row

  void add(const std::string& path, const Json& entry) {
    if (!entry.is_object() || !entry.contains(name_key) || !entry.contains("representation")) {
      throw InputError(path, "hierarchy and walks", "entries with " + std::string(name_key) + " and representation",
                       entry.dump());
    }
    size_t at = 0;
    while (at < rows.size() && (rows[at][name_key] != entry[name_key] || rows[at]["representation"] != entry["representation"]))
      ++at;
    if (at == rows.size()) {
      rows.push_back({{name_key, entry[name_key]}, {"representation", entry["representation"]}});
      entries.emplace_back();
    }
    entries[at].push_back(entry);
  }

  // The mean of every figure, of the worst ones the largest; null where a scene has none.
  Json take() {
    for (size_t at = 0; at < rows.size(); ++at) {
      rows[at]["scenes"] = entries[at].size();
      for (const auto& [key, value] : entries[at].front().items()) {
        if (key == "scene" || rows[at].contains(key)) continue;
        rows[at][key] = combined(entries[at], key);
      }
    }
    return std::move(rows);
  }

  static Json combined(const std::vector<Json>& entries, const std::string& key) {
    double sum = 0.0, largest = 0.0;
    for (const Json& entry : entries) {
      if (!entry.contains(key) || !entry[key].is_number()) return nullptr;
      sum += entry[key].get<double>();
      largest = std::max(largest, entry[key].get<double>());
    }
    return key.ends_with("_worst") ? largest : sum / static_cast<double>(entries.size());
  }
};

Front frontOf(const std::string& over, const std::vector<FrontPoint>& points, const std::vector<std::string>& names,
              const FrontTolerances& tolerances) {
  Front front{frontMembers(points, tolerances), {}};
  front.sentence = frontSentence(over, points, front.members, names);
  return front;
}

}  // namespace

FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, TentFigures tent,
                          const FrontTolerances& tolerances) {
  std::vector<FrontPoint> all, hard;
  std::vector<std::string> names;
  for (size_t p = 0; p < points.size(); ++p) {
    const double us = figures[p].time.median_us;
    all.push_back({us, figures[p].rmse.median, points[p].may_be_on_front && figures[p].rmse.median < tent.rmse.median});
    // the time is that of a bake, which does not know beforehand what is hard
    if (figures[p].rmse_hard) {
      const double median = figures[p].rmse_hard->median;
      hard.push_back({us, median, points[p].may_be_on_front && median < tent.rmse_hard->median});
    }
    names.push_back(points[p].representation + ": " + points[p].label);
  }
  FrontierResult result{std::move(points), std::move(figures), std::move(tent), {}, {}};
  result.all = frontOf("", all, names, tolerances);
  if (!hard.empty()) result.hard = frontOf(" over hard functions", hard, names, tolerances);
  return result;
}

Json pointsJson(const FrontierResult& result) {
  Json json = {{"points", Json::array()}};
  for (size_t p = 0; p < result.points.size(); ++p) {
    json["points"].push_back(pointJson(result.points[p], result.figures[p], result.all.members[p],
                                       result.figures[p].rmse_hard && result.hard.members[p]));
  }
  addErrors(result.tent.rmse, json["bare_tent"]);
  json["bare_tent"]["hard"] = nullptr;
  if (result.tent.rmse_hard) {
    json["bare_tent"]["hard"] = Json::object();
    addErrors(*result.tent.rmse_hard, json["bare_tent"]["hard"]);
  }
  for (const auto& [scene, rmse] : result.tent.by_scene) addErrors(rmse, json["bare_tent"]["by_scene"][scene]);
  json["front_sentence"] = result.all.sentence;
  json["hard_front_sentence"] = result.hard.sentence;
  return json;
}

std::string pointsCsv(const FrontierResult& result) {
  std::string csv =
      "representation,family,budget,label,us_median,us_p25,us_p75,rmse_mean,rmse_median,rmse_p5,rmse_p95,rmse_worst,"
      "leak_p99,on_front,hard_rmse_mean,hard_rmse_median,hard_rmse_p5,hard_rmse_p95,hard_rmse_worst,on_hard_front\n";
  for (size_t p = 0; p < result.points.size(); ++p) {
    const PlotPoint& point = result.points[p];
    const PointFigures& figures = result.figures[p];
    const std::string budget = point.budget ? fmt::format("{}", *point.budget) : "";
    const std::string hard = figures.rmse_hard ? csvErrors(*figures.rmse_hard) + (result.hard.members[p] ? ",1" : ",0") : ",,,,,";
    csv += fmt::format("{},{},{},{},{},{:.6g},{},{}\n", point.representation, point.family, budget, csvField(point.label),
                       csvFigures(figures.time, figures.rmse), figures.leak_p99, result.all.members[p] ? 1 : 0, hard);
  }
  return csv;
}

void addHierarchies(const std::vector<std::string>& paths, Json& frontier) {
  SceneMean hierarchy{"step"}, walks{"functions"};
  for (const std::string& path : paths) {
    const Json scene = readHierarchy(path);
    for (const Json& entry : scene["hierarchy"]) hierarchy.add(path, entry);
    for (const Json& entry : scene["walks"]) walks.add(path, entry);
  }
  frontier["hierarchy"] = hierarchy.take();
  frontier["walks"] = walks.take();
}

}  // namespace nlg
