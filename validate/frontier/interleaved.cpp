#include "validate/frontier/interleaved.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/generator/projection.h"
#include "tool/error.h"

namespace nlg {
namespace {

// What takes longer on a block has its own weights and functions in the caches for most of that time.
constexpr double kColdSeconds = 0.02;

BlockTimes timesOf(size_t block, const std::vector<FittedFunction>& functions) {
  BlockTimes times{block, {}};
  for (const FittedFunction& function : functions) times.elapsed_us.push_back(function.elapsed_us);
  return times;
}

class Interleaved {
 public:
  Interleaved(const FunctionSet& set, const ChosenFunctions& functions, const std::vector<FunctionBlock>& blocks,
              const std::vector<PlotRun>& runs, const CheckOptions& check)
      : functions_(functions),
        blocks_(blocks),
        runs_(runs),
        check_(check),
        meter_(set, check.loss()),
        block_s_(runs.size(), 0.0) {
    for (const PlotRun& run : runs) measured_.emplace_back(run.points.size());
  }

  // The first run on a block: errors, and how long it takes.
  void measureErrors(size_t r, size_t b) {
    const WallStopwatch watch;
    const FittedFunctions points = runs_[r].run(blocks_[b]);
    if (b == 0) block_s_[r] = 1e-6 * watch.elapsedUs();
    NLG_CHECK(points.size(), ==, runs_[r].points.size());
    for (size_t p = 0; p < points.size(); ++p) addErrors(runs_[r].points[p], blocks_[b], points[p], measured_[r][p]);
    addTimes(r, b, points);
  }

  bool isShort(size_t r, const InterleaveOptions& options) const { return block_s_[r] <= options.repeat_seconds; }

  // The times of cold caches are not those that the repeats are about to give.
  void forgetTimes(size_t r) {
    for (PointMeasurement& point : measured_[r]) point.times.clear();
  }

  void repeat(size_t r, size_t b) {
    if (block_s_[r] <= kColdSeconds) runs_[r].run(blocks_[b]);
    addTimes(r, b, runs_[r].run(blocks_[b]));
  }

  std::vector<PointMeasurement> take() {
    std::vector<PointMeasurement> all;
    for (auto& points : measured_) std::move(points.begin(), points.end(), std::back_inserter(all));
    return all;
  }

 private:
  void addErrors(const PlotPoint& point, const FunctionBlock& block, const std::vector<FittedFunction>& fitted,
                 PointMeasurement& measured) {
    NLG_CHECK(fitted.size(), ==, block.functions.size());
    for (size_t i = 0; i < fitted.size(); ++i) {
      const bool is_hard = functions_.hard[measured.rmse.size()];
      const float* theta = fitted[i].theta.data();
      const FunctionError error = meter_.measure(fitted[i].representation, theta, block.functions[i]);
      if (!std::isfinite(error.blend_rmse)) {
        throw NumericalError("validate frontier", point.representation + ": " + point.label,
                             "blend RMSE of function " + std::to_string(block.functions[i]), error.blend_rmse);
      }
      measured.blend_rmse.push_back(error.blend_rmse);
      measured.rmse.push_back(error.rmse);
      measured.fails_check.push_back(!checker_.check(fitted[i].representation, block.stored[i], theta, check_).passes(check_));
      measured.took_fit.push_back(fitted[i].took_fit);
      measured.leaks.add(meter_.leakMagnitudes());
      if (is_hard) measured.leaks_hard.add(meter_.leakMagnitudes());
    }
  }

  void addTimes(size_t r, size_t b, const FittedFunctions& points) {
    for (size_t p = 0; p < points.size(); ++p) measured_[r][p].times.push_back(timesOf(b, points[p]));
  }

  const ChosenFunctions& functions_;
  const std::vector<FunctionBlock>& blocks_;
  const std::vector<PlotRun>& runs_;
  const CheckOptions& check_;
  ErrorMeter meter_;
  FunctionChecker checker_;
  std::vector<std::vector<PointMeasurement>> measured_;  // by run, then by its points
  std::vector<double> block_s_;                          // by run: wall time of its first
};

}  // namespace

std::vector<FunctionBlock> makeBlocks(const FunctionSet& set, const std::vector<uint64_t>& functions) {
  const size_t block_count = (functions.size() + kBatchCount - 1) / kBatchCount;
  std::vector<FunctionBlock> blocks(block_count);
  for (size_t b = 0; b < block_count; ++b) {
    FunctionBlock& block = blocks[b];
    const size_t begin = b * functions.size() / block_count, end = (b + 1) * functions.size() / block_count;
    for (size_t i = begin; i < end; ++i) {
      const StoredFunction stored = storedFunction(set, functions[i]);
      block.functions.push_back(functions[i]);
      block.stored.push_back(stored);
    }
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
  Interleaved interleaved(set, functions, blocks, runs, check);
  int64_t done = 0;
  for (size_t b = 0; b < blocks.size(); ++b) {
    for (size_t r = 0; r < runs.size(); ++r) {
      interleaved.measureErrors(r, b);
      progress(++done);
    }
  }
  for (size_t r = 0; r < runs.size(); ++r) {
    if (interleaved.isShort(r, options) && options.repeats > 0) interleaved.forgetTimes(r);
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (size_t b = 0; b < blocks.size(); ++b) {
      for (size_t r = 0; r < runs.size(); ++r) {
        if (interleaved.isShort(r, options)) interleaved.repeat(r, b);
        progress(++done);
      }
    }
  }
  return interleaved.take();
}

}  // namespace nlg
