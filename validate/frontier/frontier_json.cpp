#include "validate/frontier/frontier_json.h"

#include <algorithm>
#include <map>

#include "validate/generators/summary_json.h"

namespace nlg {
namespace {

using Mask = std::vector<bool>;  // of functions that take a theta: which of them count

using Json = nlohmann::ordered_json;

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

// over   the figures of a mask of functions
template <class Over>
Json byPopulationAndScene(const FunctionSet& set, const ChosenFunctions& functions, const Over& over) {
  Json json;
  // a population without functions is null, not 0
  for (const Population population : kPopulations) {
    const Mask counts = functions.of(population);
    const bool is_empty = std::find(counts.begin(), counts.end(), true) == counts.end();
    json["figures"][populationName(population)] = is_empty ? Json(nullptr) : over(counts);
  }
  json["by_scene"] = Json::object();
  for (const auto& [scene, mask] : masksByScene(set, functions)) json["by_scene"][scene] = over(mask);
  return json;
}

Json wordsJson(const std::vector<ThetaWord>& words) {
  Json json = Json::array();
  for (const ThetaWord word : words) json.push_back(wordName(word));
  return json;
}

}  // namespace

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

Json tentFigures(const FunctionSet& set, const ChosenFunctions& functions, const LossOptions& loss) {
  ErrorMeter meter(set, loss);
  std::vector<double> errors;
  for (const uint64_t function : functions.with_theta) errors.push_back(meter.measureTent(function).blend_rmse);
  return byPopulationAndScene(set, functions, [&](const Mask& counts) {
    return Json{{"blend_rmse_mean", mean(picked(errors, counts))}};
  });
}

Json pointFigures(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                  const std::vector<FunctionBlock>& blocks) {
  Json json = byPopulationAndScene(set, functions, [&](const Mask& counts) {
    std::vector<double> us = timeSamples(measured, blocks, counts), errors = picked(measured.blend_rmse, counts);
    const Quantiles blend = quantiles(errors);
    return Json{{"us_median", quantile(us, 0.5)},
                {"us_p25", quantile(us, 0.25)},
                {"us_p75", quantile(us, 0.75)},
                {"blend_rmse_mean", blend.mean},
                {"blend_rmse_median", blend.median},
                {"blend_rmse_p5", quantile(errors, 0.05)},
                {"blend_rmse_p95", blend.p95},
                {"blend_rmse_worst", blend.worst},
                {"rmse_mean", mean(picked(measured.rmse, counts))}};
  });
  for (const Population population : kPopulations) {
    Json& of = json["figures"][populationName(population)];
    if (of.is_null()) continue;
    const auto shareOf = [&](const std::vector<bool>& is) {
      return mean(picked({is.begin(), is.end()}, functions.of(population)));
    };
    of["leak_p99"] = (population == Population::hard ? measured.leaks_hard : measured.leaks).quantile(0.99);
    of["share_failing_check"] = shareOf(measured.fails_check);
    of["share_fitted"] = shareOf(measured.took_fit);
  }
  return json;
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

Json frontierJson(const std::vector<PlotPoint>& points, const std::vector<Json>& figures, const Json& tent, const Json& speeds) {
  Json json = {{"points", Json::array()}, {"bare_tent", tent}};
  std::vector<std::string> names;
  for (size_t p = 0; p < points.size(); ++p) {
    const PlotPoint& point = points[p];
    names.push_back(point.representation + ": " + point.label);
    json["points"].push_back({{"representation", point.representation},
                              {"family", point.family},
                              {"budget", point.budget ? Json(*point.budget) : Json(nullptr)},
                              {"label", point.label},
                              {"words", wordsJson(point.words)}});
    json["points"].back().update(figures[p]);
  }
  for (const Population population : kPopulations) {
    const char* const name = populationName(population);
    const Json& of_tent = tent.at("figures").at(name);
    json["front_sentences"][name] = "";
    if (of_tent.is_null()) continue;
    std::vector<FrontPoint> times_and_errors;
    for (const Json& point : figures) {
      const Json& of = point.at("figures").at(name);
      const double error = of.at("blend_rmse_mean");
      times_and_errors.push_back({of.at("us_median").get<double>(), error, error < of_tent.at("blend_rmse_mean").get<double>()});
    }
    const std::vector<bool> members = frontMembers(times_and_errors, {});
    for (size_t p = 0; p < points.size(); ++p) json["points"][p]["figures"][name]["on_front"] = static_cast<bool>(members[p]);
    json["front_sentences"][name] = frontSentence(populationWords(population), times_and_errors, members, names);
  }
  json["speed_at_equal_error"] = speeds;
  return json;
}

}  // namespace nlg
