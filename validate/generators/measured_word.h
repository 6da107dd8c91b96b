// Measures one word of the policy: network, corrected, fitted, stored, or the fits that they are compared with.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "validate/generators/populations.h"
#include "validate/generators/statistics.h"

namespace nlg {

// The error of one theta against one function, measured every way that the report shows.
struct FunctionError {
  double blend_rmse = 0;  // over valid support points, the root of the loss: what fits minimise, and what errors are judged by
  double rmse = 0;        // over the same points, all of which count alike
  double rmse_test_points = 0;  // over valid test points, which no fit has seen, and of which no S is known
  double rmse_occluded = 0;     // over valid support points that the probe does not see; 0 when there are none
  bool has_occluded = false;
  double leak_mean = 0;  // mean |value| over occluded points whose phi is stored as 0; 0 when there are none
  double leak_p99 = 0;   // 99th percentile of the same
};

// Points that all functions of a set share, prepared once. One of these a thread.
//
// A leak is weight where the probe does not see and where phi is 0. FunctionCheck does not know what the probe sees, and counts every
// valid point whose phi is stored as 0; a twentieth of these it does see, at the tent's rim, where the tent rounds to 0.
class ErrorMeter {
 public:
  // loss   that blend RMSEs are of: the policy's
  ErrorMeter(const FunctionSet& set, const LossOptions& loss);

  // index   function of the set
  FunctionError measure(const Representation& representation, const float* theta, uint64_t index);

  // The same for the bare tent, no network at all.
  FunctionError measureTent(uint64_t index);

  // |value| at every point that counted for leaks in what was measured last.
  const std::vector<double>& leakMagnitudes() const { return leak_magnitudes_; }

 private:
  FunctionError compare(const float* values, const float* test_values, uint64_t index);

  const FunctionSet& set_;
  LossWeights weights_;
  PointSet points_, test_points_;  // pattern order
  AlignedFloats values_, test_values_;
  std::vector<double> leak_magnitudes_, sorted_;
};

// One function at this word.
struct MeasuredFunction {
  uint64_t function = 0;  // of the set
  FunctionError error;
  bool fails_check = false;
  bool fitted = false;  // took any step of Adam or Levenberg–Marquardt up to this word
  double elapsed_us = 0.0;
};

// What leaks are pooled over: the functions of every population, of the set and of the sample.
class PopulationLeaks {
 public:
  // magnitudes   of one function's points
  void add(const std::vector<double>& magnitudes, uint64_t function, const Populations& populations);
  void add(const PopulationLeaks& other);
  const PooledMagnitudes& of(Scope scope, Population population) const { return pools_[index(scope, population)]; }

 private:
  static size_t index(Scope scope, Population population) {
    return static_cast<size_t>(scope) * kPopulationCount + static_cast<size_t>(population);
  }
  std::array<PooledMagnitudes, static_cast<size_t>(kScopeCount) * kPopulationCount> pools_;
};

struct MeasuredWord {
  std::string name;
  std::vector<MeasuredFunction> functions;  // all of the set, or those of the sample, rising
  PopulationLeaks leaks;
};

// What one thread measures words with.
struct WordMeter {
  ErrorMeter meter;
  FunctionChecker checker;
  NormalEquationsKernel kernel;
  std::vector<PopulationLeaks> leaks;  // by word
};
using WordMeters = std::vector<std::unique_ptr<WordMeter>>;  // by thread
WordMeters wordMeters(const FunctionSet& set, const ValidateOptions& options, size_t word_count);

// Adds up what leaks on all threads: leaks pool the points of all functions (docs/theory/errors.md).
// throws   NumericalError when an error is not finite
void finishWords(const WordMeters& meters, std::vector<MeasuredWord>* words);

// The bare tent on every function of the set.
MeasuredWord measureTents(const FunctionSet& set, const Populations& populations, const ValidateOptions& options);

}  // namespace nlg
