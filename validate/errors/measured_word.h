// One word of the chain from function to grid, measured: network, corrected, fitted, stored, or the fits that they are held against.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "runtime_eval/fit/function_check.h"
#include "validate/errors/function_error.h"
#include "validate/errors/populations.h"

namespace nlg {

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

  // throws   NumericalError when an error is not finite
  void mustBeFinite() const;
};

// The bare tent on every function of the set.
MeasuredWord measureTents(const FunctionSet& set, const Populations& populations, const ValidateOptions& options);

}  // namespace nlg
