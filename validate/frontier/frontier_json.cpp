#include "validate/frontier/frontier_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "tool/atomic_file.h"
#include "tool/error.h"
#include "validate/generators/figures.h"

namespace nlg {
namespace {

using Mask = std::vector<bool>;  // of functions that take a theta: which of them count

TimeFigures timeFigures(std::vector<double> samples) {
  return {quantile(samples, 0.5), quantile(samples, 0.25), quantile(samples, 0.75)};
}

ErrorFigures errorFigures(std::vector<double> errors) {
  const Quantiles all = quantiles(errors);
  return {all.mean, all.median, quantile(errors, 0.05), all.p95, all.worst};
}

std::vector<double> picked(const std::vector<double>& values, const Mask& counts) {
  std::vector<double> some;
  for (size_t i = 0; i < values.size(); ++i) {
    if (counts[i]) some.push_back(values[i]);
  }
  return some;
}

// Where every block begins in the list of all functions.
std::vector<size_t> beginnings(const std::vector<FunctionBlock>& blocks) {
  std::vector<size_t> begin = {0};
  for (const FunctionBlock& block : blocks) begin.push_back(begin.back() + block.functions.size());
  return begin;
}

// One a run on a block that holds any function that counts: the mean over these.
std::vector<double> timeSamples(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks, const Mask& counts) {
  const std::vector<size_t> begin = beginnings(blocks);
  std::vector<double> samples;
  for (const BlockTimes& times : measured.times) {
    const auto first = counts.begin() + static_cast<std::ptrdiff_t>(begin[times.block]);
    const std::vector<double> some =
        picked(times.elapsed_us, Mask(first, first + static_cast<std::ptrdiff_t>(times.elapsed_us.size())));
    if (!some.empty()) samples.push_back(mean(some));
  }
  return samples;
}

std::map<std::string, Mask> masksByScene(const FunctionSet& set, const ChosenFunctions& functions) {
  std::map<std::string, Mask> masks;
  for (size_t i = 0; i < functions.with_theta.size(); ++i) {
    const std::string& scene = set.scene_ids[set.scene_idx[functions.with_theta[i]]];
    masks.try_emplace(scene, functions.with_theta.size(), false).first->second[i] = true;
  }
  return masks;
}

bool any(const Mask& mask) { return std::find(mask.begin(), mask.end(), true) != mask.end(); }

using Json = nlohmann::ordered_json;

Json figuresJson(const FrontierFigures& figures) {
  const ErrorFigures& blend = figures.blend_rmse;
  return {{"us_median", figures.time.median_us}, {"us_p25", figures.time.p25_us},     {"us_p75", figures.time.p75_us},
          {"blend_rmse_mean", blend.mean},       {"blend_rmse_median", blend.median}, {"blend_rmse_p5", blend.p5},
          {"blend_rmse_p95", blend.p95},         {"blend_rmse_worst", blend.worst},   {"rmse_mean", figures.rmse_mean}};
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
  // a population without functions is null, not 0
  for (const Population population : kPopulations) json["figures"][populationName(population)] = nullptr;
  for (const auto& [population, figures] : result.figures[p].figures) {
    Json& of = json["figures"][populationName(population)] = figuresJson(figures);
    of["leak_p99"] = figures.leak_p99;
    of["share_failing_check"] = figures.share_failing_check;
    of["share_fitted"] = figures.share_fitted;
    of["on_front"] = static_cast<bool>(result.fronts.at(population).members[p]);
  }
  json["by_scene"] = Json::object();
  for (const auto& [scene, figures] : result.figures[p].by_scene) json["by_scene"][scene] = figuresJson(figures);
  return json;
}

Json tentJson(const TentFigures& tent) {
  Json json;
  for (const Population population : kPopulations) json["figures"][populationName(population)] = nullptr;
  for (const auto& [population, error] : tent.figures) json["figures"][populationName(population)] = {{"blend_rmse_mean", error}};
  json["by_scene"] = Json::object();
  for (const auto& [scene, error] : tent.by_scene) json["by_scene"][scene] = {{"blend_rmse_mean", error}};
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

TentFigures figuresOfTent(const FunctionSet& set, const ChosenFunctions& functions, const LossOptions& loss) {
  ErrorMeter meter(set, loss);
  std::vector<double> errors;
  for (const uint64_t function : functions.with_theta) errors.push_back(meter.measureTent(function).blend_rmse);
  TentFigures figures;
  for (const Population population : kPopulations) {
    const Mask counts = functions.of(population);
    if (any(counts)) figures.figures[population] = mean(picked(errors, counts));
  }
  for (const auto& [scene, mask] : masksByScene(set, functions)) figures.by_scene[scene] = mean(picked(errors, mask));
  return figures;
}

PointFigures figuresOf(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                       const std::vector<FunctionBlock>& blocks) {
  // over a mask of functions, so that populations and scenes share their figures
  const auto over = [&](const Mask& counts) {
    return FrontierFigures{timeFigures(timeSamples(measured, blocks, counts)), errorFigures(picked(measured.blend_rmse, counts)),
                           mean(picked(measured.rmse, counts))};
  };
  PointFigures figures;
  for (const Population population : kPopulations) {
    const Mask counts = functions.of(population);
    if (!any(counts)) continue;
    const auto shareOf = [&](const std::vector<bool>& is) { return mean(picked({is.begin(), is.end()}, counts)); };
    const PooledMagnitudes& leaks = population == Population::hard ? measured.leaks_hard : measured.leaks;
    figures.figures[population] = {over(counts), leaks.quantile(0.99), shareOf(measured.fails_check), shareOf(measured.took_fit)};
  }
  for (const auto& [scene, mask] : masksByScene(set, functions)) figures.by_scene[scene] = over(mask);
  return figures;
}

std::vector<double> functionTimes(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks) {
  const std::vector<size_t> begin = beginnings(blocks);
  std::vector<std::vector<double>> runs(begin.back());
  for (const BlockTimes& times : measured.times) {
    for (size_t i = 0; i < times.elapsed_us.size(); ++i) runs[begin[times.block] + i].push_back(times.elapsed_us[i]);
  }
  std::vector<double> median;
  for (std::vector<double>& of_function : runs) median.push_back(quantile(of_function, 0.5));
  return median;
}

FrontierResult makeResult(std::vector<PlotPoint> points, std::vector<PointFigures> figures, TentFigures tent) {
  FrontierResult result{std::move(points), std::move(figures), std::move(tent), {}, {}};
  std::vector<std::string> names;
  for (const PlotPoint& point : result.points) names.push_back(point.representation + ": " + point.label);
  for (const auto& [population, tent_error] : result.tent.figures) {
    std::vector<FrontPoint> times_and_errors;
    for (const PointFigures& point : result.figures) {
      const PopulationFigures& of = point.figures.at(population);
      times_and_errors.push_back({of.time.median_us, of.blend_rmse.mean, of.blend_rmse.mean < tent_error});
    }
    Front& front = result.fronts[population];
    front.members = frontMembers(times_and_errors, {});
    front.sentence = frontSentence(populationWords(population), times_and_errors, front.members, names);
  }
  return result;
}

Json pointsJson(const FrontierResult& result) {
  Json json = {{"points", Json::array()}};
  for (size_t p = 0; p < result.points.size(); ++p) json["points"].push_back(pointJson(result, p));
  json["bare_tent"] = tentJson(result.tent);
  for (const Population population : kPopulations) json["front_sentences"][populationName(population)] = "";
  for (const auto& [population, front] : result.fronts) json["front_sentences"][populationName(population)] = front.sentence;
  json["speed_at_equal_error"] = speedsJson(result.speeds);
  return json;
}

}  // namespace nlg
