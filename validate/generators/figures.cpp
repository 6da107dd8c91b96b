#include "validate/generators/figures.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

Json ends(const Interval& interval) { return {interval.low, interval.high}; }

// Figures over values of functions, each with its function's scene.
struct ValuesByScene {
  std::vector<double> values;
  std::vector<uint32_t> scenes;

  void add(double value, uint32_t scene) { values.push_back(value), scenes.push_back(scene); }
};

// The columns of one population.
struct Columns {
  std::vector<uint32_t> scenes;  // of all but the occluded ones
  std::vector<double> blend_rmse, rmse, rmse_test_points, fails, fitted, elapsed_us;
  ValuesByScene rmse_occluded;
};

Columns columnsOf(const MeasuredWord& word, Scope scope, Population population, const FigureContext& context) {
  Columns columns;
  for (const MeasuredFunction& one : word.functions) {
    if (!context.populations.contains(scope, population, one.function)) continue;
    const uint32_t scene = context.set.scene_idx[one.function];
    columns.scenes.push_back(scene);
    columns.blend_rmse.push_back(one.error.blend_rmse);
    columns.rmse.push_back(one.error.rmse);
    columns.rmse_test_points.push_back(one.error.rmse_test_points);
    if (one.error.has_occluded) columns.rmse_occluded.add(one.error.rmse_occluded, scene);
    columns.fails.push_back(one.fails_check);
    columns.fitted.push_back(one.fitted);
    columns.elapsed_us.push_back(one.elapsed_us);
  }
  return columns;
}

// {median, mean, p95, p99, worst, functions}, and interval {median, mean, p95}: [low, high] each.
Json quantilesJson(const std::vector<double>& values, const SceneBootstrap& bootstrap) {
  const Quantiles q = quantiles(values);
  Json json = {{"median", q.median}, {"mean", q.mean},   {"p95", q.p95},
               {"p99", q.p99},       {"worst", q.worst}, {"functions", q.count}};
  const std::vector<Interval> quantiles = bootstrap.quantiles(values, {0.5, 0.95});
  json["interval"] = {{"median", ends(quantiles[0])}, {"mean", ends(bootstrap.mean(values))}, {"p95", ends(quantiles[1])}};
  return json;
}

Json figures(const MeasuredWord& word, Scope scope, Population population, const FigureContext& context) {
  const Columns columns = columnsOf(word, scope, population, context);
  const SceneBootstrap bootstrap(columns.scenes, context.bootstrap);
  const PooledMagnitudes& leaks = word.leaks.of(scope, population);
  return {{"functions", columns.rmse.size()},
          {"blend_rmse", quantilesJson(columns.blend_rmse, bootstrap)},
          {"rmse", quantilesJson(columns.rmse, bootstrap)},
          {"rmse_test_points", quantilesJson(columns.rmse_test_points, bootstrap)},
          {"rmse_occluded",
           quantilesJson(columns.rmse_occluded.values, SceneBootstrap(columns.rmse_occluded.scenes, context.bootstrap))},
          {"leak", {{"mean", leaks.mean()}, {"p99", leaks.quantile(0.99)}}},
          {"share_failing_check", intervalJson(bootstrap.mean(columns.fails))},
          {"share_fitted", intervalJson(bootstrap.mean(columns.fitted))},
          {"us_per_function", mean(columns.elapsed_us)}};
}

}  // namespace

Json intervalJson(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

Json figuresByPopulation(const MeasuredWord& word, Scope scope, const FigureContext& context) {
  Json json;
  for (int p = 0; p < kPopulationCount; ++p) {
    const auto population = static_cast<Population>(p);
    json[populationName(population)] = figures(word, scope, population, context);
  }
  return json;
}

Json ratiosJson(const MeasuredWord& word, const MeasuredWord& reference, const FigureContext& context) {
  Json json;
  for (const auto& [name, population] : {std::pair("median", Population::theta), {"median_hard", Population::hard}}) {
    ValuesByScene ratios;
    size_t at = 0;  // in the word's functions, which rise as the reference's do
    for (const MeasuredFunction& one : reference.functions) {
      while (word.functions[at].function != one.function) ++at;
      if (!context.populations.contains(Scope::sample, population, one.function) || !(one.error.blend_rmse > 0.0)) continue;
      ratios.add(word.functions[at].error.blend_rmse / one.error.blend_rmse, context.set.scene_idx[one.function]);
    }
    const SceneBootstrap bootstrap(ratios.scenes, context.bootstrap);
    json[name] = intervalJson(bootstrap.quantiles(ratios.values, {0.5}).front());
  }
  return json;
}

}  // namespace nlg
