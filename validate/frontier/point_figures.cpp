#include "validate/frontier/point_figures.h"

namespace nlg {
namespace {

TimeFigures timeFigures(std::vector<double> samples) {
  return {quantile(samples, 0.5), quantile(samples, 0.25), quantile(samples, 0.75)};
}

ErrorFigures errorFigures(std::vector<double> rmse) {
  const Quantiles all = quantiles(rmse);
  return {all.mean, all.median, quantile(rmse, 0.05), all.p95, all.worst};
}

// What one scene's functions give.
struct SceneSamples {
  std::vector<double> time_us, rmse;
};

}  // namespace

TentFigures figuresOfTent(const std::vector<double>& tent_rmse, const std::vector<FunctionBlock>& blocks, const FunctionSet& set,
                          const std::vector<bool>& hard) {
  std::vector<double> rmse_hard;
  std::map<uint32_t, std::vector<double>> by_scene;
  size_t at = 0;
  for (const FunctionBlock& block : blocks) {
    for (const uint64_t function : block.functions) {
      if (hard[at]) rmse_hard.push_back(tent_rmse[at]);
      by_scene[set.scene_idx[function]].push_back(tent_rmse[at++]);
    }
  }
  TentFigures figures{errorFigures(tent_rmse), {}, {}};
  if (!rmse_hard.empty()) figures.rmse_hard = errorFigures(rmse_hard);
  for (const auto& [scene, rmse] : by_scene) figures.by_scene[set.scene_ids[scene]] = errorFigures(rmse);
  return figures;
}

PointFigures figuresOf(const PointMeasurement& measured, const std::vector<FunctionBlock>& blocks, const FunctionSet& set,
                       const std::vector<bool>& hard) {
  std::map<uint32_t, SceneSamples> by_scene;
  std::vector<double> time_us, rmse, rmse_hard;
  size_t at = 0;
  for (const FunctionBlock& block : blocks) {
    for (const uint64_t function : block.functions) {
      rmse.push_back(measured.errors[at].rmse);
      if (hard[at++]) rmse_hard.push_back(rmse.back());
      by_scene[set.scene_idx[function]].rmse.push_back(rmse.back());
    }
  }
  for (const BlockTimes& times : measured.times) {
    time_us.push_back(mean(times.elapsed_us));
    std::map<uint32_t, std::vector<double>> of_scene;
    for (size_t i = 0; i < times.elapsed_us.size(); ++i) {
      of_scene[set.scene_idx[blocks[times.block].functions[i]]].push_back(times.elapsed_us[i]);
    }
    for (const auto& [scene, elapsed_us] : of_scene) by_scene[scene].time_us.push_back(mean(elapsed_us));
  }
  PointFigures figures{timeFigures(time_us), errorFigures(rmse), {}, measured.leaks.quantile(0.99), {}};
  if (!rmse_hard.empty()) figures.rmse_hard = errorFigures(rmse_hard);
  for (const auto& [scene, samples] : by_scene) {
    figures.by_scene[set.scene_ids[scene]] = {timeFigures(samples.time_us), errorFigures(samples.rmse)};
  }
  return figures;
}

}  // namespace nlg
