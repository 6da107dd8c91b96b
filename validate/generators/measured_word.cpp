#include "validate/generators/measured_word.h"

#include <cmath>

#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

bool bit(const std::vector<uint8_t>& bits, uint64_t row, size_t width, size_t i) {
  return bits[row * (width / 8) + i / 8] >> (i % 8) & 1;
}

struct MeanSquare {
  double sum = 0.0;
  uint64_t count = 0;
  void add(double residual) { sum += residual * residual, ++count; }
  double root() const { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0; }
};

}  // namespace

ErrorMeter::ErrorMeter(const FunctionSet& set, const LossOptions& loss)
    : set_(set),
      weights_(loss),
      points_(makePointSet(supportPattern().points)),
      test_points_(makePointSet(testPoints(set.test_point_count))),
      values_(points_.padded_count),
      test_values_(test_points_.padded_count) {}

FunctionError ErrorMeter::measure(const Representation& representation, const float* theta, uint64_t index) {
  evaluate(representation, points_, theta, values_.data());
  evaluate(representation, test_points_, theta, test_values_.data());
  return compare(values_.data(), test_values_.data(), index);
}

FunctionError ErrorMeter::measureTent(uint64_t index) { return compare(points_.tent.data(), test_points_.tent.data(), index); }

FunctionError ErrorMeter::compare(const float* values, const float* test_values, uint64_t index) {
  const size_t point_count = set_.point_count, test_count = set_.test_point_count;
  // docs/theory/errors.md: the loss, and plain RMSE of all valid, of occluded and of test points
  MeanSquare loss, all, occluded, test;
  leak_magnitudes_.clear();
  for (size_t i = 0; i < point_count; ++i) {
    if (!bit(set_.validity, index, point_count, i)) continue;
    const uint8_t phi = set_.phi[index * point_count + i];
    const double residual = values[i] - phi / 255.0;
    const uint8_t sum = set_.blend_sum.empty() ? uint8_t{255} : set_.blend_sum[index * point_count + i];
    loss.add(weights_.root(phi, points_.tent[i], sum) * residual);
    all.add(residual);
    // leaks: occluded points whose stored byte is 0
    if (bit(set_.seen, index, point_count, i)) continue;
    occluded.add(residual);
    if (phi != 0) continue;
    leak_magnitudes_.push_back(std::fabs(values[i]));
  }
  // test points have no weights of the loss: S is known at support points alone
  for (size_t i = 0; i < test_count; ++i) {
    if (!bit(set_.validity_test, index, test_count, i)) continue;
    test.add(test_values[i] - set_.phi_test[index * test_count + i] / 255.0);
  }
  // the quantile sorts a copy: the caller pools the magnitudes as they are
  sorted_ = leak_magnitudes_;
  return {
      loss.root(), all.root(), test.root(), occluded.root(), occluded.count > 0, mean(leak_magnitudes_), quantile(sorted_, 0.99)};
}

void PopulationLeaks::add(const std::vector<double>& magnitudes, uint64_t function, const Populations& populations) {
  for (int s = 0; s < kScopeCount; ++s) {
    for (int p = 0; p < kPopulationCount; ++p) {
      const auto scope = static_cast<Scope>(s);
      const auto population = static_cast<Population>(p);
      if (populations.contains(scope, population, function)) pools_[index(scope, population)].add(magnitudes);
    }
  }
}

void PopulationLeaks::add(const PopulationLeaks& other) {
  for (size_t i = 0; i < pools_.size(); ++i) pools_[i].add(other.pools_[i]);
}

WordMeters wordMeters(const FunctionSet& set, const ValidateOptions& options, size_t word_count) {
  WordMeters meters;
  for (int t = 0; t < options.threadCount(); ++t) {
    meters.push_back(std::unique_ptr<WordMeter>(
        new WordMeter{ErrorMeter(set, options.policy.check().loss()), {}, {}, std::vector<PopulationLeaks>(word_count)}));
  }
  return meters;
}

void finishWords(const WordMeters& meters, std::vector<MeasuredWord>* words) {
  for (size_t w = 0; w < words->size(); ++w) {
    MeasuredWord& word = (*words)[w];
    for (const auto& meter : meters) word.leaks.add(meter->leaks[w]);
    for (const MeasuredFunction& one : word.functions) {
      for (const double rmse : {one.error.blend_rmse, one.error.rmse, one.error.rmse_test_points}) {
        if (!std::isfinite(rmse))
          throw NumericalError("validate", "function " + std::to_string(one.function), word.name + ": RMSE", rmse);
      }
    }
  }
}

MeasuredWord measureTents(const FunctionSet& set, const Populations& populations, const ValidateOptions& options) {
  std::vector<MeasuredWord> words = {{"tent", std::vector<MeasuredFunction>(set.functionCount()), {}}};
  const WordMeters meters = wordMeters(set, options, words.size());
  parallelFor(set.functionCount(), options.threadCount(), [&](uint64_t i, int t) {
    WordMeter& thread = *meters[t];
    const FunctionCheck check = thread.checker.checkBareTent(storedFunction(set, i), options.policy.check());
    words[0].functions[i] = {i, thread.meter.measureTent(i), !check.passes(options.policy.check()), false, 0.0};
    thread.leaks[0].add(thread.meter.leakMagnitudes(), i, populations);
  });
  finishWords(meters, &words);
  return words[0];
}

}  // namespace nlg
