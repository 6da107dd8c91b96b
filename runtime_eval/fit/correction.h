// Correction at bake time: what a generator can still do about a theta that is wrong about its function, in tens of microseconds
// to a millisecond.
//
// First the last layer is solved exactly (networks with a linear output whose weights say so). A learned step then measures theta on
// its function, error and gradient, and lets a small network say how theta should change. A function that is still not good enough
// is tried again as its mirror images: to the generator each is another function, with another theta and other mistakes, and
// theta mirrors back exactly. Where an iteration of Levenberg–Marquardt is cheap, for product fields and for networks of few numbers,
// a few of them end the correction, and theta_0 is one more start for a function that is still not good enough: there they gain more
// in the same time than learned steps. Elsewhere a short run of Adam ends it, for functions that are not good enough. docs/theory/math.md §6; what each setting costs and gives: docs/lab/training.md.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

struct CorrectionOptions {
  double correct_rmse = 0.001;  // theta whose RMSE is not above stay as they are
  int most_steps = 8;           // learned steps of an attempt: they end at the first that does not pay; 0: none
  int mirror_images = 8;        // networks: attempts at a function at most, itself and then its mirror images; 1 … 8
  double retry_rmse = 0.005;    // no further attempt at a function whose RMSE is not above; up to twice that for a generator that
                                // is nearly as wrong about the tent
  double adam_rmse = 0.003;     // elsewhere: a function whose RMSE is above (raised likewise) …
  int adam_steps = 500;         // … takes so many steps of Adam in the end
  int iterations = 4;           // where they are cheap: of Levenberg–Marquardt, after the learned steps
  int theta0_iterations = 32;   // … and from theta_0, for a function whose RMSE is above retry_rmse even then
};

// Product fields, whose normal equations are a band, and networks of at most 32 numbers.
bool iteratesCheaply(const Representation& representation);

// One of these a thread and generator.
class Corrector {
 public:
  // generator   must outlive it. Without correction steps or an exact last layer in its weights nothing is ever corrected
  explicit Corrector(const Generator& generator, const CorrectionOptions& options = {});

  bool empty() const { return generator_->correctionStepCount() == 0 && !generator_->exactLastLayer(); }

  // Theta is the best by RMSE over all valid support points of what it was and of all that was met, so it is never worse than it
  // came. Nothing beyond the range of float16 is taken.
  // functions   count of them
  // theta       count x D, all of this generator's representation; one of a function without a valid point stays as it is
  // returns     how many theta changed
  int correct(const StoredFunction* functions, int count, float* theta);

 private:
  int correctBatch(const StoredFunction* functions, int count, float* theta);
  void decode(const StoredFunction& stored, int mirror);
  // Mean square of a theta on function_; infinite where it is not finite or there is no point.
  double meanSquare(const float* theta) const;
  // current_ and the mirrored coefficients of the functions that go on.
  void startAttempt(int mirror, const float* theta);
  void runSteps(const StoredFunction* functions, int mirror, float* theta);
  // Error of current_ of every function that still goes on and, when the network is to run, what it reads; the last layers are
  // solved before.
  void measure(const StoredFunction* functions, int mirror, bool network_runs);
  void writeFeatures(int i, size_t row);
  // Takes over what became better; leaves going_on_ with the functions for which the last step paid, their features closed up.
  void keepBetter(int mirror, float* theta);
  // RMSE of the generator's theta for the bare tent: what it cannot do better for any function.
  double tentRmse();
  // What ends the correction of function i.
  void fitOn(const StoredFunction& stored, int i, float* theta);
  // On function_, the i-th of the batch, from `start`; take over what is better than theta of that function.
  void iterate(int i, const float* start, int iterations, float* theta);
  void stepAdam(int i, const float* start, int steps, float* theta);
  // theta_, whose mean square on function_ is `error`, for theta of function i where it is better.
  void takeFitted(int i, double error, float* theta);

  const Generator* generator_;
  CorrectionOptions options_;
  // mean squares that are good enough: for the first attempt, for any further, for the fit in the end; infinite where there is none
  double correct_square_ = 0.0, retry_square_ = 0.0, fit_square_ = 0.0;
  GeneratorScratch generator_scratch_;
  LayerScratch layer_scratch_;
  CorrectionFeatures places_;
  std::vector<uint8_t> phi_;             // one batch
  AlignedFloats coefficients_;           // one batch
  AlignedFloats mirrored_;               // of the attempt: by function of the batch
  AlignedFloats rows_;                   // … of those that are tried, one after another
  std::vector<float> current_, change_;  // one batch; theta of the mirror image at work
  std::vector<double> best_error_;       // by function of the batch: of what theta holds
  std::vector<double> error_;            // … of current_
  std::vector<double> attempt_error_;    // … least of this attempt
  std::vector<uint8_t> changed_;         // by function of the batch
  std::vector<int> going_on_;            // indices into the batch
  WeightingFunction function_;           // the one at work
  int valid_count_ = 0;                  // its valid points
  std::vector<float> gradient_, theta_;  // one function
  SymmetricBand equations_;              // of the last layer
  NormalEquationsKernel normal_equations_;
  LevenbergMarquardtWorkspace levenberg_workspace_;
  AdamWorkspace adam_workspace_;
};

}  // namespace nlg
