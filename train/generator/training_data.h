// The functions that training reads, and their coefficients.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/projection.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

class TrainingData {
 public:
  // Projects every function once; mirror images need no more than signs.
  TrainingData(FunctionSet set, const BasisData& basis);

  int64_t functionCount() const { return static_cast<int64_t>(set_.functionCount()); }
  int coefficientCount() const { return coefficient_count_; }
  const FunctionSet& set() const { return set_; }

  StoredFunction function(int64_t index) const;

  // Standardised coefficients of the function mirrored by `mirror`, K floats.
  void copyCoefficients(int64_t index, int mirror, float* coefficients) const;

 private:
  FunctionSet set_;
  int coefficient_count_;
  std::array<int, kParityClassCount> class_count_;
  std::vector<float> coefficients_;  // N x K
};

// One sample of a training step: which function, mirrored how, judged on which batch of its points (point_order.h).
struct Sample {
  int64_t function = 0;
  int mirror = 0;
  int batch = 0;
};

// The samples of any training step, a pure function of (seed, step): a resumed run draws what an uninterrupted one would have.
// Functions come in a fresh random order every epoch; mirror and batch of points are drawn for each.
class SampleOrder {
 public:
  // batch               samples a step
  // point_batch_count   batches of points that there are to draw from
  SampleOrder(int64_t function_count, int batch, int point_batch_count, uint64_t seed);
  std::vector<Sample> samples(int64_t step);

 private:
  void shuffle(int64_t epoch);

  int64_t function_count_;
  int batch_, point_batch_count_;
  uint64_t seed_;
  int64_t epoch_ = -1;
  std::vector<uint32_t> order_;
};

}  // namespace nlg
