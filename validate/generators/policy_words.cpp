#include "validate/generators/policy_words.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>

#include "runtime_eval/policy/stage_runner.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

MeasuredFunction measured(uint64_t function, const FunctionError& error, const ThetaRecord& record, ThetaWord word,
                          const CheckOptions& check) {
  const bool may_be_fitted = word == ThetaWord::fitted || word == ThetaWord::stored;
  return {function, error, !record.at(word).passes(check), may_be_fitted && record.took_fit, record.elapsedUs(word)};
}

}  // namespace

std::vector<MadeTheta> runPolicy(const std::vector<const Generator*>& generators, const std::vector<StoredFunction>& functions,
                                 const PolicyOptions& policy, const PolicyRunOptions& options, const UseTheta& use) {
  std::vector<std::unique_ptr<ThetaPolicy>> policies;  // by thread
  for (int t = 0; t < options.threads; ++t) policies.push_back(std::make_unique<ThetaPolicy>(generators, policy));
  const bool traces = use && generators.size() == 1;
  const auto theta_count = static_cast<size_t>(generators.front()->representation().thetaCount());
  std::vector<MadeTheta> made(functions.size());
  const auto batch = static_cast<uint64_t>(options.batch);
  parallelForBlocks(functions.size(), batch, options.threads, [&](uint64_t begin, uint64_t end, int thread) {
    ThetaTrace trace;
    policies[thread]->bake(&functions[begin], static_cast<int>(end - begin), &made[begin], traces ? &trace : nullptr);
    size_t at = 0;  // in the trace
    for (uint64_t i = begin; use && i < end; ++i) {
      ThetaByWord theta{};
      if (!made[i].isBareTent()) {
        if (traces) theta = {&trace.network[at], &trace.corrected[at], &trace.fitted[at], nullptr};
        theta.back() = made[i].theta.data();
        at += theta_count;
      }
      use(thread, i, made[i], theta);
    }
  });
  return made;
}

std::vector<StoredFunction> storedFunctions(const FunctionSet& set) {
  std::vector<StoredFunction> functions;
  for (uint64_t i = 0; i < set.functionCount(); ++i) functions.push_back(storedFunction(set, i));
  return functions;
}

PolicyWords measurePolicy(const Generator& generator, const FunctionSet& set, const Populations& populations,
                          const ValidateOptions& options) {
  PolicyWords result;
  // the words: a theta after the network, corrected, fitted, and stored
  for (int w = 0; w < kThetaWordCount; ++w) {
    result.words.push_back({wordName(static_cast<ThetaWord>(w)), std::vector<MeasuredFunction>(set.functionCount()), {}});
  }
  const WordMeters meters = wordMeters(set, options, kThetaWordCount);
  Progress progress(std::string(representationName(generator.representation())) + ": functions",
                    static_cast<int64_t>(set.functionCount()));
  std::mutex mutex;
  int64_t done = 0;
  // starts of the long fits: of what the policy made of the sample, the better of before and after rounding
  const std::vector<uint64_t>& sample = populations.sample();
  result.least_wrong.resize(sample.size());
  const auto keepLeastWrong = [&](uint64_t i, const MadeTheta& made, const ThetaByWord& theta) {
    const auto place = std::lower_bound(sample.begin(), sample.end(), i);
    if (place == sample.end() || *place != i) return;
    const bool rounding_helped = made.record.at(ThetaWord::stored).blend_rmse < made.record.at(ThetaWord::fitted).blend_rmse;
    const float* first = theta[static_cast<size_t>(rounding_helped ? ThetaWord::stored : ThetaWord::fitted)];
    result.least_wrong[place - sample.begin()].assign(first, first + made.theta.size());
  };
  // measured where it is made: a theta is kept only while it is measured
  const UseTheta measure = [&](int t, uint64_t i, const MadeTheta& made, const ThetaByWord& theta) {
    ErrorMeter& meter = meters[t]->meter;
    FunctionError tent;
    // functions without a theta count with the error of the bare tent, in every word
    if (made.isBareTent()) tent = meter.measureTent(i);
    for (int w = 0; w < kThetaWordCount; ++w) {
      const auto word = static_cast<ThetaWord>(w);
      const FunctionError error = made.isBareTent() ? tent : meter.measure(generator.representation(), theta[w], i);
      result.words[w].functions[i] = measured(i, error, made.record, word, options.policy.check());
      meters[t]->leaks[w].add(meter.leakMagnitudes(), i, populations);
    }
    if (!made.isBareTent()) keepLeastWrong(i, made, theta);
    const std::lock_guard lock(mutex);
    progress.update(++done);
  };
  result.made = runPolicy({&generator}, storedFunctions(set), options.policy, {options.threadCount()}, measure);
  finishWords(meters, &result.words);
  result.plan = ThetaPolicy({&generator}, options.policy).plan(0);
  return result;
}

double measureEvaluation(const Representation& representation) {
  const PointSet points = makePointSet(supportPattern().points);
  const Theta theta = randomTheta(representation, 1);
  AlignedFloats values(points.padded_count);
  std::vector<double> elapsed_us(201);  // the median leaves out the first, on cold caches, and whatever is interrupted
  for (double& elapsed : elapsed_us) {
    const auto start = std::chrono::steady_clock::now();
    evaluate(representation, points, theta.data(), values.data());
    elapsed = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
  }
  return quantile(elapsed_us, 0.5);
}

}  // namespace nlg
