// Theta of weighting functions: generated, checked, and corrected where that is called for.
#pragma once

#include <vector>

#include "bake/bake_options.h"
#include "bake/bake_savings.h"
#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/function_check.h"

namespace nlg {

// One of these a thread.
class ThetaMaker {
 public:
  // What it did since construction. Seconds by the clock.
  struct Work {
    double generator_s = 0.0, check_s = 0.0, correction_s = 0.0;
    uint64_t checked = 0, right = 0;  // predicted theta; of these need no correction
    uint64_t corrected = 0;           // were replaced by better ones
  };

  // generators   must outlive it, as must options
  ThetaMaker(const std::vector<Generator>& generators, const BakeOptions& options, const BakeSavings& savings);

  // Theta of the g-th generator for a batch of functions, at most kBatchCount; they are in theta(g, i) until the next call for g.
  // returns   how good they are
  std::vector<FunctionCheck> make(const std::vector<StoredFunction>& functions, size_t g);
  // The same for one function, corrected whatever its error, unchecked.
  void makeCorrected(const StoredFunction& function, size_t g);
  const float* theta(size_t g, size_t i) const { return &theta_[g][i * thetaCount(g)]; }

  FunctionCheck check(const StoredFunction& function, size_t g, const float* theta);

  size_t thetaCount(size_t g) const { return static_cast<size_t>(generators_[g].representation().thetaCount()); }
  const Work& work() const { return work_; }

 private:
  void correct(const std::vector<StoredFunction>& functions, const std::vector<size_t>& wrong, size_t g,
               std::vector<FunctionCheck>* checks);

  const std::vector<Generator>& generators_;
  const BakeOptions& options_;
  BakeSavings savings_;
  std::vector<GeneratorScratch> scratch_;  // by generator
  std::vector<Corrector> corrector_;       // by generator
  std::vector<std::vector<float>> theta_;  // by generator: one batch
  std::vector<uint8_t> phi_;               // one batch
  FunctionChecker checker_;
  Work work_;
};

}  // namespace nlg
