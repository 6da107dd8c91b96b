#include "validate/frontier/point_figures.h"

#include <algorithm>

namespace nlg {
namespace {

TimeFigures timeFigures(std::vector<double> samples, double scale = 1.0) {
  for (double& sample : samples) sample *= scale;
  return {quantile(samples, 0.5), quantile(samples, 0.25), quantile(samples, 0.75)};
}

ErrorFigures errorFigures(std::vector<double> rmse) {
  const Quantiles all = quantiles(rmse);
  return {all.mean, all.median, quantile(rmse, 0.05), all.p95, all.worst};
}

std::vector<double> joined(std::vector<double> first, const std::vector<double>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::vector<double> hardOnes(const std::vector<double>& values, const std::vector<bool>& hard) {
  std::vector<double> some;
  for (size_t i = 0; i < values.size(); ++i) {
    if (hard[i]) some.push_back(values[i]);
  }
  return some;
}

// 0 without any.
double shareOf(const std::vector<bool>& taken, const std::vector<bool>& of) {
  size_t count = 0, all = 0;
  for (size_t i = 0; i < taken.size(); ++i) {
    all += of[i] ? 1 : 0;
    count += of[i] && taken[i] ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(count) / static_cast<double>(all) : 0.0;
}

// Where every block begins in the list of all functions.
std::vector<size_t> beginnings(const std::vector<FunctionBlock>& blocks) {
  std::vector<size_t> begin = {0};
  for (const FunctionBlock& block : blocks) begin.push_back(begin.back() + block.functions.size());
  return begin;
}

// What one scene's functions give.
struct SceneSamples {
  std::vector<double> time_us, rmse;
};

}  // namespace

BareTents measureBareTents(const FunctionSet& set, const ChosenFunctions& functions) {
  BareTents tents;
  ErrorMeter meter(set);
  for (const uint64_t function : functions.bare_tents) tents.rmse.push_back(meter.measureTent(function, &tents.leaks).rmse);
  return tents;
}

TentFigures figuresOfTent(const FunctionSet& set, const ChosenFunctions& functions, const BareTents& tents) {
  std::map<uint32_t, std::vector<double>> by_scene;
  for (size_t i = 0; i < functions.with_theta.size(); ++i) {
    by_scene[set.scene_idx[functions.with_theta[i]]].push_back(functions.tent_rmse[i]);
  }
  const std::vector<double> hard = hardOnes(functions.tent_rmse, functions.hard);
  TentFigures figures;
  figures.figures = {errorFigures(joined(functions.tent_rmse, tents.rmse)), errorFigures(functions.tent_rmse), std::nullopt};
  if (!hard.empty()) figures.figures[static_cast<size_t>(Population::hard)] = errorFigures(hard);
  for (const auto& [scene, rmse] : by_scene) figures.by_scene[set.scene_ids[scene]] = errorFigures(rmse);
  return figures;
}

PointFigures figuresOf(const PointMeasurement& measured, const FunctionSet& set, const ChosenFunctions& functions,
                       const std::vector<FunctionBlock>& blocks, const BareTents& tents) {
  const std::vector<size_t> begin = beginnings(blocks);
  std::map<uint32_t, SceneSamples> by_scene;
  for (size_t i = 0; i < measured.rmse.size(); ++i) {
    by_scene[set.scene_idx[functions.with_theta[i]]].rmse.push_back(measured.rmse[i]);
  }
  std::vector<double> time_us, time_us_hard;
  for (const BlockTimes& times : measured.times) {
    std::map<uint32_t, std::vector<double>> of_scene;
    std::vector<double> of_hard;
    for (size_t i = 0; i < times.elapsed_us.size(); ++i) {
      const size_t n = begin[times.block] + i;
      of_scene[set.scene_idx[functions.with_theta[n]]].push_back(times.elapsed_us[i]);
      if (functions.hard[n]) of_hard.push_back(times.elapsed_us[i]);
    }
    time_us.push_back(mean(times.elapsed_us));
    if (!of_hard.empty()) time_us_hard.push_back(mean(of_hard));
    for (const auto& [scene, elapsed_us] : of_scene) by_scene[scene].time_us.push_back(mean(elapsed_us));
  }
  const auto count = static_cast<double>(functions.with_theta.size());
  const double share_with_theta = count / (count + static_cast<double>(tents.rmse.size()));
  const double share_fitted = shareOf(measured.took_fit, std::vector<bool>(measured.took_fit.size(), true));
  PooledMagnitudes leaks_all = measured.leaks;
  leaks_all.add(tents.leaks);
  PointFigures figures;
  figures.figures = {
      PopulationFigures{timeFigures(time_us, share_with_theta), errorFigures(joined(measured.rmse, tents.rmse)),
                        leaks_all.quantile(0.99), share_fitted * share_with_theta},
      PopulationFigures{timeFigures(time_us), errorFigures(measured.rmse), measured.leaks.quantile(0.99), share_fitted},
      std::nullopt};
  if (!time_us_hard.empty()) {
    figures.figures[static_cast<size_t>(Population::hard)] =
        PopulationFigures{timeFigures(time_us_hard), errorFigures(hardOnes(measured.rmse, functions.hard)),
                          measured.leaks_hard.quantile(0.99), shareOf(measured.took_fit, functions.hard)};
  }
  for (const auto& [scene, samples] : by_scene) {
    figures.by_scene[set.scene_ids[scene]] = {timeFigures(samples.time_us), errorFigures(samples.rmse)};
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

}  // namespace nlg
