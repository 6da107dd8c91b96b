// Learned correction steps at bake time: a second look at theta that the generator was wrong about.
//
// A step measures theta on its function, error and gradient, and lets a small network say how theta should change. It costs about one
// evaluation with gradient, tens of microseconds, where Adam or Levenberg–Marquardt need milliseconds. docs/math.md §6.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// One of these a thread and generator.
class Corrector {
 public:
  // generator   must outlive it. Without correction steps in its weights nothing is ever corrected
  explicit Corrector(const Generator& generator);

  bool empty() const { return generator_->correctionStepCount() == 0; }

  // Applies the generator's number of steps to every theta. A function's steps end when one does not lower its error over all
  // valid support points; theta is then the best that was met, so it is never worse than it came.
  // functions   count of them
  // theta       count x D, all of this generator's representation; one that is not finite stays as it is
  // returns     how many theta changed
  int correct(const StoredFunction* functions, int count, float* theta);

 private:
  int correctBatch(const StoredFunction* functions, int count, float* theta);
  // Error of the theta of every function that still goes on, and, but for the last time, what the network reads.
  void measure(const StoredFunction* functions, const float* theta, bool want_features);

  const Generator* generator_;
  GeneratorScratch generator_scratch_;
  LayerScratch layer_scratch_;
  CorrectionFeatures places_;
  std::vector<uint8_t> phi_;    // one batch
  AlignedFloats coefficients_;  // one batch
  std::vector<float> current_, change_, gradient_;
  std::vector<double> best_error_, error_;
  std::vector<uint8_t> changed_;
  std::vector<int> going_on_;  // indices into the batch
  WeightingFunction function_;
};

}  // namespace nlg
