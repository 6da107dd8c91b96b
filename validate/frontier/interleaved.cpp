#include "validate/frontier/interleaved.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/generator/projection.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Every so-many-th of a list.
std::vector<uint64_t> spread(const std::vector<uint64_t>& list, uint64_t wanted) {
  std::vector<uint64_t> some;
  for (uint64_t i = 0; i < wanted; ++i) some.push_back(list[i * list.size() / wanted]);
  return some;
}

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
  constexpr const char* kWords[] = {"all functions", "functions that take a θ", "hard functions"};
  return kWords[static_cast<size_t>(population)];
}

uint64_t ChosenFunctions::count(Population population) const {
  switch (population) {
    case Population::all:
      return with_theta.size() + bare_tents.size();
    case Population::theta:
      return with_theta.size();
    case Population::hard:
      return static_cast<uint64_t>(std::count(hard.begin(), hard.end(), true));
  }
  return 0;
}

ChosenFunctions chooseFunctions(const FunctionSet& set, uint64_t wanted, const PolicyOptions& policy, double hard_tent_rmse) {
  const size_t scene_count = set.scene_ids.size();
  FunctionChecker checker;
  std::vector<uint64_t> taking;
  std::vector<uint32_t> taking_scene;
  std::vector<bool> hard(set.functionCount());
  std::vector<std::vector<uint64_t>> tents_of(scene_count);
  std::vector<uint64_t> taking_of(scene_count, 0), chosen_of(scene_count, 0);
  // the bake's own rule parts the functions: those that take a theta, and bare tents
  for (uint64_t i = 0; i < set.functionCount(); ++i) {
    const FunctionCheck tent = checker.checkBareTent(storedFunction(set, i), policy.check());
    const uint32_t scene = set.scene_idx[i];
    hard[i] = tent.rmse >= hard_tent_rmse;
    if (takesBareTent(tent, policy)) {
      tents_of[scene].push_back(i);
      continue;
    }
    taking.push_back(i);
    taking_scene.push_back(scene);
    ++taking_of[scene];
  }
  if (taking.empty()) throw InputError("held-out shards", "functions", "one that takes a theta", "bare tents only");
  ChosenFunctions chosen;
  // evenly over scenes, so that one large level does not decide
  for (const uint64_t n : chooseEvenly(taking_scene, scene_count, wanted)) {
    const uint64_t i = taking[n];
    chosen.with_theta.push_back(i);
    chosen.hard.push_back(hard[i]);
    ++chosen_of[taking_scene[n]];
  }
  for (size_t s = 0; s < scene_count; ++s) {
    // a scene where nothing takes a theta stands there with one scene's share
    const double share = taking_of[s] > 0 ? static_cast<double>(chosen_of[s]) / static_cast<double>(taking_of[s])
                                          : static_cast<double>(chosen.with_theta.size()) /
                                                static_cast<double>(scene_count * std::max<size_t>(1, tents_of[s].size()));
    const auto count = static_cast<uint64_t>(std::lround(std::min(1.0, share) * static_cast<double>(tents_of[s].size())));
    const std::vector<uint64_t> some = spread(tents_of[s], count);
    chosen.bare_tents.insert(chosen.bare_tents.end(), some.begin(), some.end());
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
