#include "validate/frontier/interleaved.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/evaluator/generator/projection.h"
#include "tool/error.h"

namespace nlg {
namespace {

// What takes longer on a block has its own weights and functions in the caches for most of that time.
constexpr double kColdSeconds = 0.1;

void addTimes(size_t block, const FittedFunctions& points, PointMeasurement* measured) {
  for (const std::vector<FittedFunction>& functions : points) {
    BlockTimes& times = (measured++)->times.emplace_back(BlockTimes{block, {}});
    for (const FittedFunction& function : functions) times.elapsed_us.push_back(function.elapsed_us);
  }
}

}  // namespace

std::vector<FunctionBlock> makeBlocks(const FunctionSet& set, const std::vector<uint64_t>& functions) {
  const size_t block_count = (functions.size() + kBatchCount - 1) / kBatchCount;
  std::vector<FunctionBlock> blocks(block_count);
  for (size_t b = 0; b < block_count; ++b) {
    FunctionBlock& block = blocks[b];
    const size_t begin = b * functions.size() / block_count, end = (b + 1) * functions.size() / block_count;
    block.functions.assign(&functions[begin], &functions[begin] + (end - begin));
    for (const uint64_t function : block.functions) block.stored.push_back(storedFunction(set, function));
  }
  return blocks;
}

const char* populationWords(Population population) {
  return population == Population::hard ? "hard functions" : "functions that take a θ";
}

std::vector<bool> ChosenFunctions::of(Population population) const {
  return population == Population::hard ? hard : std::vector<bool>(with_theta.size(), true);
}

ChosenFunctions chooseFunctions(const FunctionSet& set, uint64_t wanted, const PolicyOptions& policy, double hard_tent_rmse) {
  FunctionChecker checker;
  std::vector<uint64_t> taking;
  std::vector<uint32_t> taking_scene;
  std::vector<bool> hard;
  // the bake's own rule says which functions take a theta
  for (uint64_t i = 0; i < set.functionCount(); ++i) {
    const FunctionCheck tent = checker.checkBareTent(storedFunction(set, i), policy.check());
    if (takesBareTent(tent, policy)) continue;
    taking.push_back(i);
    taking_scene.push_back(set.scene_idx[i]);
    hard.push_back(tent.rmse >= hard_tent_rmse);
  }
  if (taking.empty()) throw InputError("held-out shards", "functions", "one that takes a theta", "bare tents only");
  ChosenFunctions chosen;
  // evenly over scenes, so that one large level does not decide
  for (const uint64_t n : chooseEvenly(taking_scene, set.scene_ids.size(), wanted)) {
    chosen.with_theta.push_back(taking[n]);
    chosen.hard.push_back(hard[n]);
  }
  return chosen;
}

std::vector<PointMeasurement> measureInterleaved(const FunctionSet& set, const ChosenFunctions& functions,
                                                 const std::vector<FunctionBlock>& blocks, const std::vector<PlotRun>& runs,
                                                 const CheckOptions& check, const InterleaveOptions& options,
                                                 const std::function<void(int64_t done)>& progress) {
  ErrorMeter meter(set, check.loss());
  FunctionChecker checker;
  const auto addErrors = [&](const PlotPoint& point, const FunctionBlock& block, const std::vector<FittedFunction>& fitted,
                             PointMeasurement& measured) {
    NLG_CHECK(fitted.size(), ==, block.functions.size());
    for (size_t i = 0; i < fitted.size(); ++i) {
      const bool is_hard = functions.hard[measured.rmse.size()];
      const float* theta = fitted[i].theta.data();
      const FunctionError error = meter.measure(fitted[i].representation, theta, block.functions[i]);
      if (!std::isfinite(error.blend_rmse)) {
        throw NumericalError("validate frontier", point.representation + ": " + point.label,
                             "blend RMSE of function " + std::to_string(block.functions[i]), error.blend_rmse);
      }
      measured.blend_rmse.push_back(error.blend_rmse);
      measured.rmse.push_back(error.rmse);
      measured.fails_check.push_back(!checker.check(fitted[i].representation, block.stored[i], theta, check).passes(check));
      measured.took_fit.push_back(fitted[i].took_fit);
      measured.leaks.add(meter.leakMagnitudes());
      if (is_hard) measured.leaks_hard.add(meter.leakMagnitudes());
    }
  };
  std::vector<size_t> first = {0};  // of a run's points in those of all
  for (const PlotRun& run : runs) first.push_back(first.back() + run.points.size());
  std::vector<PointMeasurement> measured(first.back());
  // by run: wall time of its fastest block; the first one touches memory that nobody touched before
  std::vector<double> block_s(runs.size(), std::numeric_limits<double>::infinity());
  int64_t done = 0;
  const auto onEveryBlock = [&](const auto& measure) {
    for (size_t b = 0; b < blocks.size(); ++b) {
      for (size_t r = 0; r < runs.size(); ++r) {
        measure(r, b);
        progress(++done);
      }
    }
  };
  // the first run on a block: errors, and how long it takes
  onEveryBlock([&](size_t r, size_t b) {
    const WallStopwatch watch;
    const FittedFunctions points = runs[r].run(blocks[b]);
    block_s[r] = std::min(block_s[r], 1e-6 * watch.elapsedUs());
    NLG_CHECK(points.size(), ==, runs[r].points.size());
    for (size_t p = 0; p < points.size(); ++p) addErrors(runs[r].points[p], blocks[b], points[p], measured[first[r] + p]);
    addTimes(b, points, measured.data() + first[r]);
  });
  const auto isShort = [&](size_t r) { return block_s[r] <= options.repeat_seconds; };
  // the times of cold caches are not those that the repeats are about to give
  for (size_t r = 0; r < runs.size(); ++r) {
    if (!isShort(r) || options.repeats <= 0) continue;
    for (size_t p = first[r]; p < first[r + 1]; ++p) measured[p].times.clear();
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    onEveryBlock([&](size_t r, size_t b) {
      if (!isShort(r)) return;
      if (block_s[r] <= kColdSeconds) runs[r].run(blocks[b]);
      addTimes(b, runs[r].run(blocks[b]), measured.data() + first[r]);
    });
  }
  return measured;
}

}  // namespace nlg
