#include "validate/frontier/timed_policy.h"

#include <numeric>
#include <utility>

#include "runtime_eval/evaluator/projection.h"
#include "runtime_eval/policy/stage_plan.h"
#include "validate/frontier/plot_point.h"

namespace nlg {
namespace {

std::vector<const Generator*> pointersTo(const SharedGenerators& generators) {
  std::vector<const Generator*> pointers;
  for (const auto& generator : generators) pointers.push_back(generator.get());
  return pointers;
}

// Rounding is asked for function by function, by runAndRound.
PolicyOptions withInt8(PolicyOptions options) {
  options.theta_precision = ThetaPrecision::int8;
  return options;
}

double recordedUs(const ThetaRecord& record) { return std::accumulate(record.stage_us.begin(), record.stage_us.end(), 0.0); }

// timed   a TimedNetwork or a TimedPolicy
template <class Timed>
PlotRun runOf(PlotPoint point, const std::shared_ptr<Timed>& timed) {
  return {{std::move(point)}, [timed](const FunctionBlock& block) { return FittedFunctions{timed->run(block)}; }};
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

}  // namespace

TimedPolicy::TimedPolicy(SharedGenerators generators, const PolicyOptions& options, ThetaStage last)
    : generators_(std::move(generators)), policy_(pointersTo(generators_), withInt8(options), last) {}

std::vector<FittedFunction> TimedPolicy::run(const FunctionBlock& block) {
  made_.resize(block.functions.size());
  const Stopwatch watch;
  policy_.make(block.stored.data(), block.count(), made_.data());
  for (size_t i = 0; i < made_.size(); ++i) policy_.refine(block.stored[i], &made_[i]);
  return fitted(block, watch.elapsedUs());
}

std::vector<FittedFunction> TimedPolicy::runAndRound(const FunctionBlock& block) {
  std::vector<FittedFunction> functions = run(block);
  for (size_t i = 0; i < made_.size(); ++i) {
    const Stopwatch watch;
    policy_.round(block.stored[i], &made_[i]);
    functions[i].elapsed_us += watch.elapsedUs();
    functions[i].theta = made_[i].theta;
  }
  return functions;
}

std::vector<FittedFunction> TimedPolicy::fitted(const FunctionBlock& block, double elapsed_us) const {
  // the record's clock is another one: what counts of it are the shares
  double recorded_us = 0.0;
  for (const MadeTheta& made : made_) recorded_us += recordedUs(made.record);
  std::vector<FittedFunction> functions;
  for (const MadeTheta& made : made_) {
    const double share = recorded_us > 0.0 ? recordedUs(made.record) / recorded_us : 1.0 / block.count();
    functions.push_back({generators_[made.generator]->representation(), made.theta, elapsed_us * share, made.record.took_fit});
  }
  return functions;
}

TimedNetwork::TimedNetwork(std::shared_ptr<const Generator> generator)
    : generator_(std::move(generator)),
      scratch_(*generator_),
      theta_(static_cast<size_t>(kBatchCount) * static_cast<size_t>(generator_->representation().thetaCount())) {}

std::vector<FittedFunction> TimedNetwork::run(const FunctionBlock& block) {
  const Stopwatch watch;
  generator_->generate(block.phi.data(), block.count(), theta_.data(), &scratch_);
  const double elapsed_us = watch.elapsedUs() / block.count();
  const Representation& representation = generator_->representation();
  const auto D = static_cast<size_t>(representation.thetaCount());
  std::vector<FittedFunction> functions;
  for (size_t i = 0; i < block.functions.size(); ++i) {
    functions.push_back({representation, Theta(&theta_[i * D], &theta_[i * D] + D), elapsed_us});
  }
  return functions;
}

std::vector<PlotRun> stagePoints(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options) {
  std::vector<PlotRun> runs;
  const std::string name = representationName(generator->representation());
  const std::vector<StagePlan> plan = stagesOf(stageFacts(*generator), options);
  for (size_t n = 0; n < plan.size(); ++n) {
    const ThetaStage stage = plan[n].stage;
    const PlotPoint point{name, "stages", {}, stageTitle(stage), wordsAfter(plan, n)};
    runs.push_back(stage == ThetaStage::network
                       ? runOf(point, std::make_shared<TimedNetwork>(generator))
                       : runOf(point, std::make_shared<TimedPolicy>(SharedGenerators{generator}, options, stage)));
  }
  const auto last = std::make_shared<TimedPolicy>(SharedGenerators{generator}, options, ThetaStage::rounding);
  const PlotPoint rounded{name, "stages", 8, "rounding to int8", {ThetaWord::stored}};
  runs.push_back({{rounded}, [last](const FunctionBlock& block) { return FittedFunctions{last->runAndRound(block)}; }});
  return runs;
}

PlotRun choicePoint(const SharedGenerators& generators, const PolicyOptions& options) {
  std::string names;
  for (const auto& generator : generators) {
    names += (names.empty() ? "" : "+") + std::string(representationName(generator->representation()));
  }
  return runOf({names, "choice", {}, "automatic choice", {}},
               std::make_shared<TimedPolicy>(generators, options, ThetaStage::rounding));
}

}  // namespace nlg
