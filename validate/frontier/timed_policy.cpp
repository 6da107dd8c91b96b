#include "validate/frontier/timed_policy.h"

#include <numeric>
#include <utility>

#include "validate/frontier/stopwatch.h"

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

}  // namespace nlg
