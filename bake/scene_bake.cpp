#include "bake/scene_bake.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "bake/theta_maker.h"
#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/fit/refinement.h"
#include "runtime_eval/numbers/half.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// What one distinct function has come to.
struct FittedFunction {
  uint8_t generator = 0;  // index
  Theta theta;
};

// Everything that one thread needs, for all stages.
struct BakeThread {
  BakeThread(const std::vector<Generator>& generators, const BakeOptions& options, const BakeSavings& savings)
      : maker(generators, options, savings) {}
  ThetaMaker maker;
  Refiner refiner;
  std::vector<uint8_t> samples;
  double refinement_s = 0.0;
  uint64_t smallest_enough = 0;
  std::array<uint64_t, kFitStopCount> stops{};
};

class SceneBake {
 public:
  SceneBake(const BakeScene& scene, const std::vector<Generator>& generators, const BakeOptions& options,
            ThetaPrecision theta_precision, const std::string& spool_folder, const BakeSavings& savings)
      : scene_(scene),
        generators_(generators),
        options_(options),
        theta_precision_(theta_precision),
        savings_(savings),
        thread_count_(options.threads > 0 ? options.threads : machineThreadCount()),
        functions_(scene, options, thread_count_, spool_folder, savings) {
    for (int t = 0; t < thread_count_; ++t) threads_.push_back(std::make_unique<BakeThread>(generators_, options_, savings_));
  }

  Bake run() {
    const Clock::time_point start = Clock::now();
    functions_.makeAll([this](const SceneFunctions::NewFunctions& made) { generateAndCheck(made); });
    statistics_.functions_wall_s = secondsSince(start);
    statistics_.generated = checks_;
    const Clock::time_point refinement_start = Clock::now();
    refineWorstFirst();
    if (!savings_.refinement) refineThosePassing();
    statistics_.refinement_wall_s = secondsSince(refinement_start);
    const RoundingError rounding = theta_precision_ == ThetaPrecision::float16 ? roundTheta() : RoundingError{};
    finishStatistics();
    statistics_.wall_s = secondsSince(start);
    return {makeGrid(), rounding, std::move(statistics_)};
  }

 private:
  void generateAndCheck(const SceneFunctions::NewFunctions& made) {
    fitted_.resize(made.first + made.functions.size());
    checks_.resize(fitted_.size());
    tent_passes_.resize(fitted_.size());
    parallelFor((made.functions.size() + kBatchCount - 1) / kBatchCount, thread_count_, [&](uint64_t batch, int thread) {
      const uint64_t begin = batch * kBatchCount;
      generateBatch(made, begin, std::min<uint64_t>(begin + kBatchCount, made.functions.size()), *threads_[thread]);
    });
  }

  // The smallest representation for all functions, the larger ones for those that it may not be enough for.
  void generateBatch(const SceneFunctions::NewFunctions& made, uint64_t begin, uint64_t end, BakeThread& thread) {
    const std::vector<StoredFunction> all(&made.functions[begin], &made.functions[begin] + (end - begin));
    const std::vector<FunctionCheck> smallest = thread.maker.make(all, 0);
    std::vector<StoredFunction> functions;
    std::vector<uint64_t> numbers;
    std::vector<std::vector<FunctionCheck>> checks;  // by function that larger generators run for, by generator
    for (size_t i = 0; i < all.size(); ++i) {
      const uint64_t number = made.first + begin + i;
      keep(number, 0, thread.maker.theta(0, i), smallest[i]);
      tent_passes_[number] = made.tent_passes[begin + i];
      const bool enough = isSmallestEnough(smallest[i], options_.refinement.check, options_.choice.forGenerated());
      thread.smallest_enough += enough;
      if (enough && savings_.larger_generators) continue;
      functions.push_back(all[i]);
      numbers.push_back(number);
      checks.push_back({smallest[i]});
    }
    if (functions.empty()) return;
    for (size_t g = 1; g < generators_.size(); ++g) {
      const std::vector<FunctionCheck> larger = thread.maker.make(functions, g);
      for (size_t i = 0; i < functions.size(); ++i) checks[i].push_back(larger[i]);
    }
    for (size_t i = 0; i < functions.size(); ++i) {
      const int chosen = chooseRepresentation(checks[i], options_.refinement.check, options_.choice.forGenerated());
      if (chosen > 0) keep(numbers[i], chosen, thread.maker.theta(chosen, i), checks[i][chosen]);
    }
  }

  void keep(uint64_t number, int generator, const float* theta, const FunctionCheck& check) {
    fitted_[number] = {static_cast<uint8_t>(generator), Theta(theta, theta + thetaCount(generator))};
    checks_[number] = check;
  }

  void refineWorstFirst() {
    if (options_.refinement.rounds == 0) return;
    const std::vector<uint32_t> order = worstFirst(checks_, options_.refinement.check);
    const Clock::time_point start = Clock::now();
    std::atomic<uint64_t> left_for_time{0};
    Progress progress("functions refined", static_cast<int64_t>(order.size()));
    std::mutex mutex;
    int64_t done = 0;
    parallelFor(order.size(), thread_count_, [&](uint64_t i, int thread) {
      if (options_.refine_seconds > 0.0 && secondsSince(start) > options_.refine_seconds) {
        ++left_for_time;
        return;
      }
      refine(order[i], *threads_[thread]);
      const std::lock_guard lock(mutex);
      progress.update(++done);
    });
    statistics_.left_for_time = left_for_time;
    statistics_.refined = order.size() - left_for_time;
  }

  // Refines the chosen representation; when it stays above the threshold, the next larger one from its own generator's theta.
  void refine(uint32_t number, BakeThread& thread) {
    const Clock::time_point start = Clock::now();
    const StoredFunction stored = functions_.read(number, &thread.samples);
    const size_t first = fitted_[number].generator;
    double least_trouble = checks_[number].trouble(options_.refinement.check);
    for (size_t g = first; g < generators_.size() && least_trouble > 1.0; ++g) {
      const Theta begin = g == first ? fitted_[number].theta : raisedStart(stored, number, g, thread);
      const RefinementResult refined =
          thread.refiner.refine(generators_[g].representation(), stored, begin, theta0Of(g), options_.refinement);
      ++thread.stops[static_cast<size_t>(refined.stop)];
      const double trouble = refined.check.trouble(options_.refinement.check);
      if (!(trouble < least_trouble)) continue;
      least_trouble = trouble;
      fitted_[number] = {static_cast<uint8_t>(g), refined.theta};
      checks_[number] = refined.check;
    }
    if (fitted_[number].generator != first) ++raised_;
    thread.refinement_s += secondsSince(start);
  }

  // One round for every function that the check let pass: what a bake without a check would do.
  void refineThosePassing() {
    RefinementOptions options = options_.refinement;
    options.check.tau_rmse = 1e-6;  // nothing passes: the round is made
    options.rounds = 1;
    parallelFor(fitted_.size(), thread_count_, [&](uint64_t number, int thread_idx) {
      if (!statistics_.generated[number].passes(options_.refinement.check)) return;
      BakeThread& thread = *threads_[thread_idx];
      FittedFunction& function = fitted_[number];
      const StoredFunction stored = functions_.read(number, &thread.samples);
      const Representation& representation = generators_[function.generator].representation();
      const RefinementResult refined = thread.refiner.refine(representation, stored, function.theta, {}, options);
      if (!refined.check.passes(options_.refinement.check)) return;
      function.theta = refined.theta;
      checks_[number] = refined.check;
    });
  }

  // Where a larger representation starts: its own generator's theta, or a field that is smaller so far, on its finer grid.
  Theta raisedStart(const StoredFunction& stored, uint32_t number, size_t g, BakeThread& thread) const {
    thread.maker.makeCorrected(stored, g);
    const float* generated = thread.maker.theta(g, 0);
    Theta start(generated, generated + thetaCount(g));
    const Representation &raised = generators_[g].representation(),
                         &present = generators_[fitted_[number].generator].representation();
    if (!raised.isField() || !present.isField()) return start;
    Theta finer(thetaCount(g));
    resampleField(present.resolution, fitted_[number].theta.data(), raised.resolution, finer.data());
    const bool finer_is_better =
        thread.maker.check(stored, g, finer.data()).rmse < thread.maker.check(stored, g, start.data()).rmse;
    return finer_is_better ? finer : start;
  }

  // Rounds theta of all functions to float16 and checks what that makes of them.
  RoundingError roundTheta() {
    std::vector<double> before;
    for (const FunctionCheck& check : checks_) before.push_back(check.rmse);
    parallelFor(fitted_.size(), thread_count_, [&](uint64_t number, int thread) {
      FittedFunction& function = fitted_[number];
      for (float& value : function.theta) {
        Half half;
        if (!halfFromFloat(value, &half)) {
          throw NumericalError("bake", "function " + std::to_string(number), "theta, for float16,", value);
        }
        value = floatFromHalf(half);
      }
      const StoredFunction stored = functions_.read(number, &threads_[thread]->samples);
      checks_[number] = threads_[thread]->maker.check(stored, function.generator, function.theta.data());
    });
    RoundingError error;
    for (size_t i = 0; i < checks_.size(); ++i) {
      const double added = checks_[i].rmse - before[i];
      error.mean_rmse_added += added / static_cast<double>(checks_.size());
      error.worst_rmse_added = std::max(error.worst_rmse_added, added);
    }
    return error;
  }

  void finishStatistics() {
    statistics_.counts = functions_.counts();
    statistics_.function_times = functions_.times();
    statistics_.raised = raised_;
    for (const auto& thread : threads_) {
      const ThetaMaker::Work& work = thread->maker.work();
      statistics_.generator_s += work.generator_s;
      statistics_.check_s += work.check_s;
      statistics_.correction_s += work.correction_s;
      statistics_.corrected += work.corrected;
      statistics_.checked += work.checked;
      statistics_.right += work.right;
      statistics_.smallest_enough += thread->smallest_enough;
      statistics_.refinement_s += thread->refinement_s;
      for (size_t stop = 0; stop < kFitStopCount; ++stop) statistics_.refinement_stops[stop] += thread->stops[stop];
    }
    const auto failing = [this](const std::vector<FunctionCheck>& checks) {
      return static_cast<uint64_t>(std::count_if(
          checks.begin(), checks.end(), [this](const FunctionCheck& check) { return !check.passes(options_.refinement.check); }));
    };
    statistics_.failed_check = failing(statistics_.generated);
    statistics_.still_failing = failing(checks_);
    statistics_.stored = checks_;
    statistics_.tent_passes = tent_passes_;
    statistics_.bare_tents = functions_.bareTents();
    statistics_.chosen.assign(generators_.size(), 0);
    for (const FittedFunction& function : fitted_) ++statistics_.chosen[function.generator];
  }

  LightGrid makeGrid() {
    LightGrid grid;
    grid.tree = scene_.tree;
    // engines look up in the world's coordinates; the scene's are relative to its middle
    const glm::dvec3& origin_m = scene_.source.scene.origin_m;
    grid.tree.moveBy({origin_m.x, origin_m.y, origin_m.z});
    grid.probe_function = functions_.probeFunction();
    // only the representations that some function uses
    std::vector<uint8_t> index_of_generator(generators_.size());
    for (size_t g = 0; g < generators_.size(); ++g) {
      if (statistics_.chosen[g] == 0) continue;
      index_of_generator[g] = static_cast<uint8_t>(grid.representations.size());
      grid.representations.push_back(generators_[g].representation());
    }
    for (const FittedFunction& function : fitted_) {
      grid.addFunction(index_of_generator[function.generator], function.theta.data());
    }
    return grid;
  }

  Theta theta0Of(size_t g) const { return {generators_[g].theta0(), generators_[g].theta0() + thetaCount(g)}; }
  size_t thetaCount(size_t g) const { return static_cast<size_t>(generators_[g].representation().thetaCount()); }

  const BakeScene& scene_;
  const std::vector<Generator>& generators_;
  BakeOptions options_;
  ThetaPrecision theta_precision_;
  BakeSavings savings_;
  int thread_count_;
  SceneFunctions functions_;
  std::vector<std::unique_ptr<BakeThread>> threads_;
  std::vector<FittedFunction> fitted_;  // by function
  std::vector<FunctionCheck> checks_;   // of fitted_
  std::vector<uint8_t> tent_passes_;    // by function
  std::atomic<uint64_t> raised_{0};
  BakeStatistics statistics_;
};

}  // namespace

Bake bakeScene(const BakeScene& scene, const std::vector<Generator>& generators, const BakeOptions& options,
               ThetaPrecision theta_precision, const std::string& spool_folder, const BakeSavings& savings) {
  return SceneBake(scene, generators, options, theta_precision, spool_folder, savings).run();
}

}  // namespace nlg
