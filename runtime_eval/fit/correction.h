// Correction steps at bake time: a second look at theta that the generator was wrong about.
//
// First the last layer is solved exactly (networks with a linear output whose weights say so). A learned step then measures theta on
// its function, error and gradient, and lets a small network say how theta should change. All steps of a function take one to three
// tenths of a millisecond (bench_runtime_eval, shipped/…/correction), Adam several milliseconds. docs/math.md §6.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// One of these a thread and generator.
class Corrector {
 public:
  // generator   must outlive it. Without correction steps in its weights nothing is ever corrected
  explicit Corrector(const Generator& generator);

  bool empty() const { return generator_->correctionStepCount() == 0 && !generator_->exactLastLayer(); }

  // Solves the last layer, then applies the generator's number of steps to every theta. A function's steps end when one does not
  // lower its error over all valid support points; theta is then the best that was met, so it is never worse than it came.
  // Nothing beyond the range of float16 is taken.
  // functions   count of them
  // theta       count x D, all of this generator's representation; one whose error is not finite stays as it is, unless a solved
  //             last layer makes it finite
  // returns     how many theta changed
  int correct(const StoredFunction* functions, int count, float* theta);

 private:
  int correctBatch(const StoredFunction* functions, int count, float* theta);
  void decode(const StoredFunction& stored);
  // Mean square of a theta on function_; infinite where there is nothing to lower.
  double meanSquare(const float* theta) const;
  // Error of current_ of every function that still goes on and, when the network is to run, what it reads; the last layers are
  // solved before.
  void measure(const StoredFunction* functions, bool network_runs);
  void writeFeatures(int i, size_t row);
  // Takes over what became better; the functions that did not end here. Returns how many go on.
  int keepBetter(bool all_go_on, float* theta);

  const Generator* generator_;
  GeneratorScratch generator_scratch_;
  LayerScratch layer_scratch_;
  CorrectionFeatures places_;
  std::vector<uint8_t> phi_;                // one batch
  AlignedFloats coefficients_;              // one batch
  std::vector<float> current_, change_;     // one batch
  std::vector<double> best_error_, error_;  // by function of the batch
  std::vector<uint8_t> changed_;            // by function of the batch
  std::vector<int> going_on_;               // indices into the batch
  WeightingFunction function_;              // the one at work
  int valid_count_ = 0;                     // its valid points
  std::vector<float> gradient_;
  SymmetricBand equations_;  // of the last layer
};

}  // namespace nlg
