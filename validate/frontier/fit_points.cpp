#include "validate/frontier/fit_points.h"

#include <fmt/format.h>
#include <algorithm>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/numbers/random.h"
#include "validate/frontier/stopwatch.h"

namespace nlg {
namespace {

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

  // With the policy's own loss: what a rival minimises too.
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

// Rounds on one function: what stands after each, under every threshold.
class GatedFit {
 public:
  GatedFit(const Fits& fits, const StoredFunction& stored, uint64_t function)
      : fits_(fits), stored_(stored), theta_(fits.startTheta(function)) {
    weighting_ = fits.decoded(stored);
    check();
    elapsed_us_ = watch_.elapsedUs();
  }

  bool isGood(double threshold) const { return nlg::isGood(check_, threshold, fits_.options.check()); }

  void fitOn(int steps) {
    if (has_ended_) return;
    const Stopwatch watch;
    const FitResult fit = fits_.fit(weighting_, theta_, steps, true, !took_fit_);
    theta_ = fit.theta;
    has_ended_ = fit.stop != FitStop::budget;
    took_fit_ = true;
    check();
    elapsed_us_ += watch.elapsedUs();
  }

  FittedFunction state() const { return {fits_.representation(), theta_, elapsed_us_, took_fit_}; }

 private:
  void check() { check_ = fits_.checker->check(fits_.representation(), stored_, theta_.data(), fits_.options.check()); }

  const Fits& fits_;
  const StoredFunction& stored_;
  const Stopwatch watch_;
  WeightingFunction weighting_;
  Theta theta_;
  FunctionCheck check_;
  double elapsed_us_ = 0.0;
  bool took_fit_ = false, has_ended_ = false;
};

// returns   by threshold, then by budget
FittedFunctions fitGated(const Fits& fits, const std::vector<double>& thresholds, const FunctionBlock& block) {
  const size_t budget_count = fits.budgets.size();
  FittedFunctions points(thresholds.size() * budget_count);
  for (size_t i = 0; i < block.functions.size(); ++i) {
    GatedFit fit(fits, block.stored[i], block.functions[i]);
    std::vector<FittedFunction> kept(thresholds.size(), fit.state());
    std::vector<bool> is_done(thresholds.size(), false);
    int steps = 0;
    for (size_t b = 0; b < budget_count; ++b) {
      for (size_t t = 0; t < thresholds.size(); ++t) is_done[t] = is_done[t] || fit.isGood(thresholds[t]);
      if (std::find(is_done.begin(), is_done.end(), false) != is_done.end()) fit.fitOn(fits.budgets[b] - steps);
      steps = fits.budgets[b];
      for (size_t t = 0; t < thresholds.size(); ++t) {
        if (!is_done[t]) kept[t] = fit.state();
        points[t * budget_count + b].push_back(kept[t]);
      }
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

// Above which blend RMSE the policy takes its last fit before the refinement; that of its first one without any.
double lastFitThreshold(const Generator& generator, const PolicyOptions& options) {
  double threshold = options.good_rmse;
  for (const StagePlan& plan : stagesOf(stageFacts(generator), options)) {
    if (isFit(plan.stage) && plan.stage < ThetaStage::refinement) threshold = plan.above_rmse;
  }
  return threshold;
}

void addDirect(const Fits& fits, double loose_rmse, std::vector<PlotRun>& runs) {
  const std::string name = representationName(fits.representation());
  for (const int budget : fits.budgets) {
    runs.push_back({{{name, fits.family(), budget, fits.label(budget), {}, true}},
                    [fits, budget](const FunctionBlock& block) { return FittedFunctions{fitAll(fits, budget, block)}; }});
  }
  const double good_rmse = fits.options.good_rmse;
  std::vector<double> thresholds = {good_rmse};
  if (loose_rmse > good_rmse) thresholds.push_back(loose_rmse);
  PlotRun gated;
  for (const double threshold : thresholds) {
    const bool is_loose = threshold > good_rmse;
    for (const int budget : fits.budgets) {
      gated.points.push_back({name,
                              fits.family() + (is_loose ? "_gated_loosely" : "_gated"),
                              budget,
                              fits.label(budget) + fmt::format(", where above {:.3g}", threshold),
                              {},
                              true});
    }
  }
  gated.run = [fits, thresholds](const FunctionBlock& block) { return fitGated(fits, thresholds, block); };
  if (!gated.points.empty()) runs.push_back(std::move(gated));
}

}  // namespace

std::vector<PlotRun> fitsOfCorrected(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options,
                                     const FitBudgets& budgets) {
  std::vector<PlotRun> runs;
  const auto corrected = std::make_shared<TimedPolicy>(SharedGenerators{generator}, options, ThetaStage::last_layer);
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
  const double loose_rmse = lastFitThreshold(*generator, options);
  const std::vector<int> adam = adamSteps(generator->representation(), budgets.direct_adam);
  addDirect({generator, Method::lm, Start::theta0, budgets.direct_lm, options}, loose_rmse, runs);
  addDirect({generator, Method::adam, Start::theta0, adam, options}, loose_rmse, runs);
  addDirect({generator, Method::adam, Start::random, adam, options, seed}, loose_rmse, runs);
  // a code's fit is as good as convex: what another start costs it is to be seen
  if (generator->representation().isCode()) {
    addDirect({generator, Method::lm, Start::random, budgets.direct_lm, options, seed}, loose_rmse, runs);
  }
  return runs;
}

}  // namespace nlg
