#include "validate/frontier/point_figures.h"

#include <algorithm>

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

}  // namespace nlg
