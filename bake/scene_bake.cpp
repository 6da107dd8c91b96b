#include "bake/scene_bake.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "runtime_eval/policy/refinement.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"
#include "tool/progress.h"

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;

// Everything that one thread needs, for all stages.
struct BakeThread {
  BakeThread(const std::vector<const Generator*>& generators, const BakeOptions& options)
      : policy(generators, options.policy, options.lastStage()) {}
  ThetaPolicy policy;
  std::vector<uint8_t> samples;
};

// A function from the first stage to the grid.
struct FunctionInWork {
  MadeTheta made;
  uint8_t chosen_first = 0;  // the generator before refinement
};

class Baking {
 public:
  Baking(const PreparedScene& scene, const std::vector<Generator>& generators, const BakeOptions& options,
         const std::string& spool_folder, const GridMetadata& metadata)
      : scene_(scene),
        generators_(generators),
        options_(options),
        thread_count_(threadsOf(options)),
        functions_(scene, options, thread_count_, spool_folder),
        metadata_(metadata) {
    std::vector<const Generator*> pointers;
    for (const Generator& generator : generators_) {
      if (options.draft && !generator.readsSamples())
        throw UsageError("--draft", "weights that read samples",
                         std::string(representationName(generator.representation())) + ", which reads coefficients");
      pointers.push_back(&generator);
    }
    for (int t = 0; t < thread_count_; ++t) threads_.push_back(std::make_unique<BakeThread>(pointers, options_));
  }

  Bake run(uint64_t collect_count) {
    const Clock::time_point start = Clock::now();
    // targets of the blend are set while functions are made, when their samples are at hand
    BlendTargets targets(scene_, options_.seed, thread_count_);
    // a draft has no samples to set them by
    if (!options_.draft) functions_.tellTargets(&targets);
    functions_.makeAll([this](int thread) {
      return [this, thread](const FunctionRows& chunk) { return makeTheta(chunk, threads_[thread]->policy); };
    });
    statistics_.functions_wall_s = secondsSince(start);
    const Clock::time_point refinement_start = Clock::now();
    if (!options_.draft) refineWorstFirst();
    statistics_.refinement_wall_s = secondsSince(refinement_start);
    roundAll();
    finishStatistics();
    FunctionRows failed;
    if (collect_count > 0) {
      std::vector<uint32_t> worst = failingWorstFirst();
      worst.resize(std::min<uint64_t>(worst.size(), collect_count));
      failed = functions_.makeAgain(worst);
    }
    LightGrid grid = makeGrid();
    statistics_.light = bakeLight(scene_, options_, &grid, metadata_);
    if (!options_.draft) statistics_.blend = blendErrors(targets, grid);
    statistics_.wall_s = secondsSince(start);
    return {std::move(grid), std::move(statistics_), std::move(failed)};
  }

 private:
  std::function<void()> makeTheta(const FunctionRows& chunk, ThetaPolicy& policy) {
    std::vector<StoredFunction> functions;
    for (uint64_t n = 0; n < chunk.functionCount(); ++n) functions.push_back(storedFunction(chunk, n));
    std::vector<MadeTheta> made(functions.size());
    policy.make(functions.data(), static_cast<int>(functions.size()), made.data());
    return [this, made = std::move(made)] {
      for (const MadeTheta& theta : made) in_work_.push_back({theta, theta.generator});
    };
  }

  std::vector<uint32_t> failingWorstFirst() const {
    std::vector<FunctionCheck> checks;
    for (const FunctionInWork& function : in_work_) checks.push_back(function.made.check());
    return worstFirst(checks, options_.policy.check());
  }

  // Worst first, so that a limit of time leaves the least trouble behind; without one the order changes nothing.
  void refineWorstFirst() {
    const std::vector<uint32_t> order = failingWorstFirst();
    const Clock::time_point start = Clock::now();
    std::atomic<uint64_t> left_for_time{0};
    Progress progress("functions refined", static_cast<int64_t>(order.size()));
    parallelFor(order.size(), thread_count_, [&](uint64_t i, int thread_idx) {
      if (options_.refine_seconds > 0.0 && secondsSince(start) > options_.refine_seconds) {
        ++left_for_time;
        return;
      }
      BakeThread& thread = *threads_[thread_idx];
      thread.policy.refine(functions_.read(order[i], &thread.samples), &in_work_[order[i]].made);
      progress.advance();
    });
    statistics_.left_for_time = left_for_time;
  }

  void roundAll() {
    if (options_.policy.theta_precision == ThetaPrecision::float32) return;
    Progress progress("functions rounded", static_cast<int64_t>(in_work_.size()));
    parallelFor(in_work_.size(), thread_count_, [&](uint64_t number, int thread_idx) {
      BakeThread& thread = *threads_[thread_idx];
      FunctionInWork& function = in_work_[number];
      if (options_.draft) {
        const Representation& representation = generators_[function.made.generator].representation();
        roundTheta(representation, options_.policy.theta_precision, function.made.theta.data());
      } else {
        thread.policy.round(functions_.read(number, &thread.samples), &function.made);
      }
      progress.advance();
    });
  }

  void finishStatistics() {
    statistics_.air.cells = scene_.air.cells.size();
    statistics_.air.airless_cells = scene_.full_tree.cellCount() - scene_.tree.cellCount();
    statistics_.air.probes = scene_.full_tree.probeCount();
    statistics_.air.drawn = scene_.air.drawn;
    statistics_.air.in_cavities = scene_.air.in_cavities;
    statistics_.air.wall_s = scene_.air_wall_s;
    statistics_.counts = functions_.counts();
    statistics_.function_times = functions_.times();
    statistics_.bare_tents = functions_.bareTents();
    for (const FunctionInWork& function : in_work_) {
      const MadeTheta& made = function.made;
      statistics_.functions.push_back({made.record, made.generator, made.generator != function.chosen_first});
    }
  }

  LightGrid makeGrid() {
    LightGrid grid;
    grid.tree = scene_.treeInWorld();
    grid.probe_function = functions_.probeFunction();
    // only the representations that some function uses
    const std::vector<uint64_t> chosen = statistics_.chosen(generators_.size());
    std::vector<uint8_t> index_of_generator(generators_.size());
    for (size_t g = 0; g < generators_.size(); ++g) {
      if (chosen[g] == 0) continue;
      index_of_generator[g] = static_cast<uint8_t>(grid.representations.size());
      grid.representations.push_back(generators_[g].representation());
    }
    for (const FunctionInWork& function : in_work_)
      grid.addFunction(index_of_generator[function.made.generator], function.made.theta.data());
    return grid;
  }

  const PreparedScene& scene_;
  const std::vector<Generator>& generators_;
  BakeOptions options_;
  int thread_count_;
  SceneFunctions functions_;
  const GridMetadata& metadata_;
  std::vector<std::unique_ptr<BakeThread>> threads_;
  std::vector<FunctionInWork> in_work_;
  BakeStatistics statistics_;
};

}  // namespace

double BakeStatistics::stageSeconds(ThetaStage stage) const {
  double sum_us = 0.0;
  for (const FunctionOutcome& function : functions) sum_us += function.record.stage_us[static_cast<size_t>(stage)];
  return 1e-6 * sum_us;
}

double BakeStatistics::wordSeconds(ThetaWord word) const {
  double sum = 0.0;
  for (int stage = 0; stage < kThetaStageCount; ++stage) {
    const auto s = static_cast<ThetaStage>(stage);
    const bool is_refinement = s == ThetaStage::refinement || s == ThetaStage::larger;
    if (s != ThetaStage::check && wordOf(s) == word && !is_refinement) sum += stageSeconds(s);
  }
  return sum;
}

uint64_t BakeStatistics::failing(ThetaWord word, const CheckOptions& check) const {
  return static_cast<uint64_t>(std::count_if(functions.begin(), functions.end(), [&](const FunctionOutcome& function) {
    return !function.record.at(word).passes(check);
  }));
}

uint64_t BakeStatistics::tookFit() const {
  return static_cast<uint64_t>(
      std::count_if(functions.begin(), functions.end(), [](const FunctionOutcome& f) { return f.record.took_fit; }));
}

uint64_t BakeStatistics::refined() const {
  return static_cast<uint64_t>(
      std::count_if(functions.begin(), functions.end(), [](const FunctionOutcome& f) { return f.record.refined; }));
}

uint64_t BakeStatistics::raised() const {
  return static_cast<uint64_t>(
      std::count_if(functions.begin(), functions.end(), [](const FunctionOutcome& f) { return f.raised; }));
}

std::vector<uint64_t> BakeStatistics::chosen(size_t generator_count) const {
  std::vector<uint64_t> uses(generator_count, 0);
  for (const FunctionOutcome& function : functions) ++uses[function.generator];
  return uses;
}

Bake bakeScene(const PreparedScene& scene, const std::vector<Generator>& generators, const BakeOptions& options,
               const std::string& spool_folder, const GridMetadata& metadata, uint64_t collect_count) {
  return Baking(scene, generators, options, spool_folder, metadata).run(collect_count);
}

}  // namespace nlg
