#include "validate/frontier/timed_policy.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/policy/stage_plan.h"

namespace nlg {
namespace {

// Rounding is asked for function by function.
PolicyOptions withInt8(PolicyOptions options) {
  options.theta_precision = ThetaPrecision::int8;
  return options;
}

double recordedUs(const ThetaRecord& record) { return std::accumulate(record.stage_us.begin(), record.stage_us.end(), 0.0); }

// One pass of the generator's network, which the policy never runs without the check that follows.
std::vector<FittedFunction> runNetwork(const Generator& generator, const FunctionBlock& block, GeneratorScratch* scratch,
                                       Theta* theta) {
  const Stopwatch watch;
  generator.generate(block.stored.data(), block.count(), theta->data(), scratch);
  const double elapsed_us = watch.elapsedUs() / block.count();
  const auto D = static_cast<size_t>(generator.representation().thetaCount());
  std::vector<FittedFunction> functions;
  for (const float* own = theta->data(); functions.size() < block.functions.size(); own += D) {
    functions.push_back({generator.representation(), Theta(own, own + D), elapsed_us});
  }
  return functions;
}

// What theta is called after a stage of the list: each word that no later stage has; stored only once it is rounded.
std::vector<ThetaWord> wordsAfter(const std::vector<StagePlan>& plan, size_t at) {
  const auto wordOfPlace = [&](size_t n) { return n == plan.size() ? ThetaWord::stored : wordOf(plan[n].stage); };
  std::vector<ThetaWord> words;
  for (auto word = static_cast<int>(wordOfPlace(at)); word < static_cast<int>(wordOfPlace(at + 1)); ++word) {
    words.push_back(static_cast<ThetaWord>(word));
  }
  return words;
}

enum class Start { corrected, theta0, random };
constexpr const char* kStartNames[] = {"corrected", "theta0", "random"};

enum class Method { lm, adam };
constexpr const char* kMethodNames[] = {"lm", "adam"};
constexpr const char* kMethodTitles[] = {"LM", "Adam"};

// As in the policy's own stages: three iterations in a row that lower the mean square by less are not worth their time.
constexpr double kGatedProgress = 0.05;

// What the fits of one family share.
struct Fits {
  std::shared_ptr<const Generator> generator;
  Method method;
  Start start;
  std::vector<int> budgets;
  PolicyOptions options;
  uint64_t seed = 0;
  std::shared_ptr<NormalEquationsKernel> kernel = std::make_shared<NormalEquationsKernel>();
  std::shared_ptr<FunctionChecker> checker = std::make_shared<FunctionChecker>();

  const Representation& representation() const { return generator->representation(); }

  // With the policy's own loss: what a baseline minimises too.
  WeightingFunction decoded(const StoredFunction& stored) const {
    return decodeFunction(stored, pointOrder(representation()), options.check().loss());
  }

  Theta startTheta(uint64_t function) const {
    if (start == Start::random) return randomTheta(representation(), mixSeed(seed, function));
    return Theta(generator->theta0(), generator->theta0() + representation().thetaCount());
  }

  // is_fresh   no fit has begun at this start yet
  FitResult fit(const WeightingFunction& function, const Theta& from, int steps, bool is_gated, bool is_fresh) const {
    if (method == Method::adam) {
      return fitAdam(representation(), function, from,
                     start == Start::random && is_fresh ? randomStartAdam(representation(), steps)
                                                        : refinementAdam(representation(), steps));
    }
    LevenbergMarquardtOptions lm = refinementLevenbergMarquardt(representation(), steps);
    if (is_gated) lm.progress_tolerance = kGatedProgress;
    return fitLevenbergMarquardt(representation(), function, from, lm, kernel.get());
  }

  std::string family() const {
    return fmt::format("{}_from_{}", kMethodNames[static_cast<int>(method)], kStartNames[static_cast<int>(start)]);
  }
  std::string label(int budget) const {
    return fmt::format("{} {} from {}", budget, kMethodTitles[static_cast<int>(method)], kStartNames[static_cast<int>(start)]);
  }
};

// One of the family's budgets, on every function.
std::vector<FittedFunction> fitAll(const Fits& fits, int budget, const FunctionBlock& block) {
  std::vector<FittedFunction> functions;
  for (size_t i = 0; i < block.functions.size(); ++i) {
    const Stopwatch watch;
    const WeightingFunction function = fits.decoded(block.stored[i]);
    Theta theta = fits.fit(function, fits.startTheta(block.functions[i]), budget, false, true).theta;
    functions.push_back({fits.representation(), std::move(theta), watch.elapsedUs(), true});
  }
  return functions;
}

// Corrected once, then every budget from there.
FittedFunctions fitOn(const Fits& fits, TimedPolicy& corrected, const FunctionBlock& block) {
  const std::vector<FittedFunction> start = corrected.run(block);
  FittedFunctions points(fits.budgets.size(), start);
  for (size_t i = 0; i < start.size(); ++i) {
    const Stopwatch decoding;
    const WeightingFunction function = fits.decoded(block.stored[i]);
    const double decoding_us = decoding.elapsedUs();
    for (size_t b = 0; b < points.size(); ++b) {
      const Stopwatch watch;
      points[b][i].theta = fits.fit(function, start[i].theta, fits.budgets[b], false, true).theta;
      points[b][i].elapsed_us += decoding_us + watch.elapsedUs();
      points[b][i].took_fit = true;
    }
  }
  return points;
}

// By budget: rounds, each from where the one before ended, until the function is as good as the threshold asks.
FittedFunctions fitGated(const Fits& fits, double threshold, const FunctionBlock& block) {
  FittedFunctions points(fits.budgets.size());
  const CheckOptions check = fits.options.check();
  for (size_t i = 0; i < block.functions.size(); ++i) {
    // decoding is part of what a bake does, and of the time
    const Stopwatch watch;
    const WeightingFunction function = fits.decoded(block.stored[i]);
    FittedFunction fitted{fits.representation(), fits.startTheta(block.functions[i])};
    const auto isDone = [&] {
      return isGood(fits.checker->check(fitted.representation, block.stored[i], fitted.theta.data(), check), threshold, check);
    };
    bool has_ended = isDone();
    fitted.elapsed_us = watch.elapsedUs();
    int steps = 0;
    // a budget goes on from where the one before ended; its time is that of all so far
    for (size_t b = 0; b < points.size(); ++b) {
      if (!has_ended) {
        const FitResult fit = fits.fit(function, fitted.theta, fits.budgets[b] - steps, true, !fitted.took_fit);
        fitted.theta = fit.theta;
        fitted.took_fit = true;
        has_ended = isDone() || fit.stop != FitStop::budget;
        fitted.elapsed_us = watch.elapsedUs();
      }
      steps = fits.budgets[b];
      points[b].push_back(fitted);
    }
  }
  return points;
}

// Budgets of Adam as fitDirect gives them to a representation.
std::vector<int> adamSteps(const Representation& representation, std::vector<int> steps) {
  if (representation.isNetwork()) return steps;
  for (int& count : steps) count = std::max(1, count / 32);
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  return steps;
}

// Above which blend RMSE the policy takes its last fit before the refinement, and good_rmse at the least.
double gateOf(const Generator& generator, const PolicyOptions& options) {
  double threshold = options.good_rmse;
  for (const StagePlan& plan : stagesOf(stageFacts(generator), options)) {
    if (isFit(plan.stage) && plan.stage < ThetaStage::refinement) threshold = std::max(plan.above_rmse, options.good_rmse);
  }
  return threshold;
}

void addDirect(const Fits& fits, double gate, std::vector<PlotRun>& runs) {
  const std::string name = representationName(fits.representation());
  PlotRun gated{{}, [fits, gate](const FunctionBlock& block) { return fitGated(fits, gate, block); }};
  for (const int budget : fits.budgets) {
    runs.push_back({{{name, fits.family(), budget, fits.label(budget), {}, true}},
                    [fits, budget](const FunctionBlock& block) { return FittedFunctions{fitAll(fits, budget, block)}; }});
    gated.points.push_back(
        {name, fits.family() + "_gated", budget, fits.label(budget) + fmt::format(", where above {:.3g}", gate), {}, true});
  }
  if (!gated.points.empty()) runs.push_back(std::move(gated));
}

}  // namespace

TimedPolicy::TimedPolicy(std::shared_ptr<const Generator> generator, const PolicyOptions& options, ThetaStage last)
    : generator_(std::move(generator)), last_(last), policy_({generator_.get()}, withInt8(options), last) {}

std::vector<FittedFunction> TimedPolicy::run(const FunctionBlock& block) {
  made_.resize(block.functions.size());
  const Stopwatch watch;
  policy_.make(block.stored.data(), block.count(), made_.data());
  for (size_t i = 0; i < made_.size(); ++i) policy_.refine(block.stored[i], &made_[i]);
  const double elapsed_us = watch.elapsedUs();
  // the record's clock is another one: what counts of it are the shares
  double recorded_us = 0.0;
  for (const MadeTheta& made : made_) recorded_us += recordedUs(made.record);
  std::vector<FittedFunction> functions;
  for (const MadeTheta& made : made_) {
    const double share = recorded_us > 0.0 ? recordedUs(made.record) / recorded_us : 1.0 / block.count();
    functions.push_back({generator_->representation(), made.theta, elapsed_us * share, made.record.took_fit});
  }
  for (size_t i = 0; last_ == ThetaStage::rounding && i < made_.size(); ++i) {
    const Stopwatch rounding;
    policy_.round(block.stored[i], &made_[i]);
    functions[i].elapsed_us += rounding.elapsedUs();
    functions[i].theta = made_[i].theta;
  }
  return functions;
}

std::vector<PlotRun> stagePoints(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options) {
  std::vector<PlotRun> runs;
  const std::string name = representationName(generator->representation());
  const std::vector<StagePlan> plan = stagesOf(stageFacts(*generator), options);
  const auto add = [&](PlotPoint point, ThetaStage stage) {
    const auto timed = std::make_shared<TimedPolicy>(generator, options, stage);
    runs.push_back({{std::move(point)}, [timed](const FunctionBlock& block) { return FittedFunctions{timed->run(block)}; }});
  };
  for (size_t n = 0; n < plan.size(); ++n) {
    const ThetaStage stage = plan[n].stage;
    PlotPoint point{name, "stages", {}, stageTitle(stage), wordsAfter(plan, n)};
    if (stage != ThetaStage::network) {
      add(std::move(point), stage);
      continue;
    }
    const auto scratch = std::make_shared<GeneratorScratch>(*generator);
    const auto theta = std::make_shared<Theta>(size_t{kBatchCount} * generator->representation().thetaCount());
    runs.push_back({{std::move(point)}, [=](const FunctionBlock& block) {
                      return FittedFunctions{runNetwork(*generator, block, scratch.get(), theta.get())};
                    }});
  }
  add({name, "stages", 8, "rounding to int8", {ThetaWord::stored}}, ThetaStage::rounding);
  return runs;
}

std::vector<PlotRun> fitsOfCorrected(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options,
                                     const FitBudgets& budgets) {
  std::vector<PlotRun> runs;
  const auto corrected = std::make_shared<TimedPolicy>(generator, options, ThetaStage::last_layer);
  for (const Method method : {Method::lm, Method::adam}) {
    const std::vector<int> steps = method == Method::lm ? budgets.lm : adamSteps(generator->representation(), budgets.adam);
    if (steps.empty()) continue;
    const Fits fits{generator, method, Start::corrected, steps, options};
    PlotRun run{{}, [fits, corrected](const FunctionBlock& block) { return fitOn(fits, *corrected, block); }};
    for (const int budget : fits.budgets) {
      run.points.push_back({representationName(generator->representation()), fits.family(), budget, fits.label(budget), {}});
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

std::vector<PlotRun> directFits(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options,
                                const FitBudgets& budgets, uint64_t seed) {
  std::vector<PlotRun> runs;
  const double gate = gateOf(*generator, options);
  const std::vector<int> adam = adamSteps(generator->representation(), budgets.direct_adam);
  addDirect({generator, Method::lm, Start::theta0, budgets.direct_lm, options}, gate, runs);
  addDirect({generator, Method::adam, Start::theta0, adam, options}, gate, runs);
  addDirect({generator, Method::adam, Start::random, adam, options, seed}, gate, runs);
  // a code's fit is as good as convex: what another start costs it is to be seen
  if (generator->representation().isCode()) {
    addDirect({generator, Method::lm, Start::random, budgets.direct_lm, options, seed}, gate, runs);
  }
  return runs;
}

}  // namespace nlg
