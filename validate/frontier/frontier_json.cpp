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

TimeFigures timeFigures(std::vector<double> samples, double scale = 1.0) {
  for (double& sample : samples) sample *= scale;
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

std::vector<double> joined(std::vector<double> first, const std::vector<double>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
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
  // a population without functions is null, not 0
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

BareTents measureBareTents(const FunctionSet& set, const ChosenFunctions& functions, const LossOptions& loss) {
  BareTents tents;
  ErrorMeter meter(set, loss);
  for (const uint64_t function : functions.with_theta) tents.with_theta.push_back(meter.measureTent(function));
  for (const uint64_t function : functions.bare_tents) {
    const FunctionError error = meter.measureTent(function);
    tents.blend_rmse.push_back(error.blend_rmse);
    tents.rmse.push_back(error.rmse);
    tents.leaks.add(meter.leakMagnitudes());
  }
  return tents;
}

TentFigures figuresOfTent(const FunctionSet& set, const ChosenFunctions& functions, const BareTents& tents) {
  std::vector<double> blend_rmse, rmse;
  for (const FunctionError& tent : tents.with_theta) blend_rmse.push_back(tent.blend_rmse), rmse.push_back(tent.rmse);
  const auto of = [&](const Mask& counts) {
    return BothErrors{errorFigures(picked(blend_rmse, counts)), errorFigures(picked(rmse, counts))};
  };
  TentFigures figures;
  figures.figures = {BothErrors{errorFigures(joined(blend_rmse, tents.blend_rmse)), errorFigures(joined(rmse, tents.rmse))},
                     of(Mask(rmse.size(), true)), std::nullopt};
  if (any(functions.hard)) figures.figures.back() = of(functions.hard);
  for (const auto& [scene, mask] : masksByScene(set, functions)) figures.by_scene[scene] = of(mask);
  return figures;
}

PointFigures figuresOf(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                       const std::vector<FunctionBlock>& blocks, const BareTents& tents) {
  // over a mask of functions, so that populations and scenes share their figures
  const auto errorsOver = [&](const Mask& counts) {
    return BothErrors{errorFigures(picked(measured.blend_rmse, counts)), errorFigures(picked(measured.rmse, counts))};
  };
  const auto figuresOver = [&](const Mask& counts, const PooledMagnitudes& leaks) {
    const auto shareOf = [&](const std::vector<bool>& is) { return mean(picked({is.begin(), is.end()}, counts)); };
    return PopulationFigures{timeFigures(timeSamples(measured, blocks, counts)), errorsOver(counts), leaks.quantile(0.99),
                             shareOf(measured.fails_check), shareOf(measured.took_fit)};
  };
  const Mask every(functions.with_theta.size(), true);
  PointFigures figures;
  figures.figures[static_cast<size_t>(Population::theta)] = figuresOver(every, measured.leaks);
  if (any(functions.hard))
    figures.figures[static_cast<size_t>(Population::hard)] = figuresOver(functions.hard, measured.leaks_hard);

  // and the bare tents, which take no time and no fit, and pass the check
  const auto count = static_cast<double>(functions.with_theta.size());
  const double share_with_theta = count / (count + static_cast<double>(tents.rmse.size()));
  PooledMagnitudes leaks = measured.leaks;
  leaks.add(tents.leaks);
  PopulationFigures all = *figures.figures[static_cast<size_t>(Population::theta)];
  all.time = timeFigures(timeSamples(measured, blocks, every), share_with_theta);
  all.errors = {errorFigures(joined(measured.blend_rmse, tents.blend_rmse)), errorFigures(joined(measured.rmse, tents.rmse))};
  all.leak_p99 = leaks.quantile(0.99);
  all.share_failing_check *= share_with_theta;
  all.share_fitted *= share_with_theta;
  figures.figures[static_cast<size_t>(Population::all)] = all;

  for (const auto& [scene, mask] : masksByScene(set, functions)) {
    figures.by_scene[scene] = {timeFigures(timeSamples(measured, blocks, mask)), errorsOver(mask)};
  }
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
