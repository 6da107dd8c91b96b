#include "validate/frontier/frontier_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "tool/atomic_file.h"
#include "tool/error.h"
#include "validate/generators/figures.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

Json errorsJson(const BothErrors& errors) {
  Json json;
  for (const auto& [name, figures] : {std::pair{"blend_rmse", &errors.blend_rmse}, {"rmse", &errors.rmse}}) {
    const std::string prefix = name;
    json[prefix + "_mean"] = figures->mean;
    json[prefix + "_median"] = figures->median;
    json[prefix + "_p5"] = figures->p5;
    json[prefix + "_p95"] = figures->p95;
    json[prefix + "_worst"] = figures->worst;
  }
  return json;
}

Json figuresJson(const TimeFigures& time, const BothErrors& errors) {
  Json json = {{"us_median", time.median_us}, {"us_p25", time.p25_us}, {"us_p75", time.p75_us}};
  json.update(errorsJson(errors));
  return json;
}

Json wordsJson(const std::vector<ThetaWord>& words) {
  Json json = Json::array();
  for (const ThetaWord word : words) json.push_back(wordName(word));
  return json;
}

Json pointJson(const FrontierResult& result, size_t p) {
  const PlotPoint& point = result.points[p];
  Json json = {{"representation", point.representation}, {"family", point.family}};
  json["budget"] = point.budget ? Json(*point.budget) : Json(nullptr);
  json["label"] = point.label;
  json["words"] = wordsJson(point.words);
  for (const Population population : kPopulations) {
    const auto& figures = result.figures[p].figures[static_cast<size_t>(population)];
    Json& of = json["figures"][populationName(population)] = nullptr;
    if (!figures) continue;
    of = figuresJson(figures->time, figures->errors);
    of["leak_p99"] = figures->leak_p99;
    of["share_failing_check"] = figures->share_failing_check;
    of["share_fitted"] = figures->share_fitted;
    of["on_front"] = static_cast<bool>(result.fronts[static_cast<size_t>(population)].members[p]);
  }
  json["by_scene"] = Json::object();
  for (const auto& [scene, of_scene] : result.figures[p].by_scene) {
    json["by_scene"][scene] = figuresJson(of_scene.time, of_scene.errors);
  }
  return json;
}

Json tentJson(const TentFigures& tent) {
  Json json;
  for (const Population population : kPopulations) {
    const auto& figures = tent.figures[static_cast<size_t>(population)];
    json["figures"][populationName(population)] = figures ? errorsJson(*figures) : Json(nullptr);
  }
  json["by_scene"] = Json::object();
  for (const auto& [scene, errors] : tent.by_scene) json["by_scene"][scene] = errorsJson(errors);
  return json;
}

Json speedJson(const EqualError& equal) {
  Json json = {{"time_us", equal.time_us},
               {"blend_rmse_mean", equal.blend_rmse_mean},
               {"share_failing_check", intervalJson(equal.share_failing)}};
  for (const char* key :
       {"baseline", "baseline_us_at_equal_error", "baseline_share_failing_check", "ratio", "longest_us", "reason"})
    json[key] = nullptr;
  if (!equal.ratio) {
    json["reason"] = equal.reason;
    if (equal.longest_us) json["longest_us"] = *equal.longest_us;
    return json;
  }
  json["baseline"] = equal.baseline;
  json["baseline_us_at_equal_error"] = equal.baseline_us;
  json["baseline_share_failing_check"] = intervalJson(equal.baseline_share_failing);
  json["ratio"] = {{"value", equal.ratio->value}, {"low", equal.ratio->low}, {"high", nullptr}};
  if (equal.ratio->high) json["ratio"]["high"] = *equal.ratio->high;
  return json;
}

Json speedsJson(const std::vector<WordSpeed>& speeds) {
  Json json = Json::object();
  for (const WordSpeed& speed : speeds) json[speed.representation][wordName(speed.word)] = speedJson(speed.equal);
  return json;
}

}  // namespace

FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, TentFigures tent,
                          const FrontTolerances& tolerances) {
  FrontierResult result{std::move(points), std::move(figures), std::move(tent), {}, {}, {}};
  std::vector<std::string> names;
  for (const PlotPoint& point : result.points) names.push_back(point.representation + ": " + point.label);
  for (const Population population : kPopulations) {
    const auto at = static_cast<size_t>(population);
    if (!result.tent.figures[at]) continue;
    std::vector<FrontPoint> times_and_errors;
    for (const PointFigures& point : result.figures) {
      const double error = point.figures[at]->errors.blend_rmse.mean;
      times_and_errors.push_back({point.figures[at]->time.median_us, error, error < result.tent.figures[at]->blend_rmse.mean});
    }
    Front& front = result.fronts[at];
    front.members = frontMembers(times_and_errors, tolerances);
    front.sentence = frontSentence(populationWords(population), times_and_errors, front.members, names);
  }
  return result;
}

Json pointsJson(const FrontierResult& result) {
  Json json = {{"points", Json::array()}};
  for (size_t p = 0; p < result.points.size(); ++p) json["points"].push_back(pointJson(result, p));
  json["bare_tent"] = tentJson(result.tent);
  for (const Population population : kPopulations) {
    json["front_sentences"][populationName(population)] = result.fronts[static_cast<size_t>(population)].sentence;
  }
  json["speed_at_equal_error"] = speedsJson(result.speeds);
  json["speed_at_equal_error_hard"] = speedsJson(result.speeds_hard);
  return json;
}

}  // namespace nlg
