// A batch of functions in the stages of one representation: the best theta of each so far, and shared state.
#pragma once

#include <vector>

#include "nlg/generator.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// One of these a thread and generator. It allocates nothing, once it is made.
class ThetaBatch {
 public:
  // generator   must outlive it
  // loss        of the functions that it hands out, and so of every mean square
  ThetaBatch(const Generator& generator, const LossOptions& loss);

  enum class Begin { network, theta0 };
  // Takes functions up, with the network's theta of each, which nobody has measured yet, or with theta0.
  // functions, theta   at most kBatchCount of them; count x D, overwritten. Both must last until the next call
  void generate(const StoredFunction* functions, int count, float* theta, Begin begin = Begin::network);

  const Generator& generator() const { return *generator_; }
  const Representation& representation() const { return generator_->representation(); }
  int count() const { return count_; }
  size_t thetaCount() const { return theta_count_; }
  const float* theta(int i) const { return theta_ + static_cast<size_t>(i) * theta_count_; }

  // Function i in the order of the representation, its points weighed; kept until another one is asked for.
  const WeightingFunction& function(int i);
  // Mean square of weighed residuals over the valid points of the function asked for last; infinite where theta is not finite or
  // there is no such point.
  double meanSquareOf(const float* theta) const;
  int validCount() const { return valid_count_; }

  // Mean square of theta(i); measured once.
  double meanSquare(int i);
  // Takes a theta for function i when its mean square is below `share` of what theta(i) has. Nothing that float16 or int8 cannot
  // hold is taken, as light grids store it.
  // returns   whether it was taken
  bool offer(int i, const float* theta, double mean_square, double share);
  // Puts back what theta(i) was before.
  void putBack(int i, const float* theta);

 private:
  void set(int i, const float* theta, double mean_square);

  const Generator* generator_;
  size_t theta_count_;
  LossOptions loss_;
  GeneratorScratch scratch_;
  const StoredFunction* functions_ = nullptr;
  int count_ = 0;
  float* theta_ = nullptr;
  std::vector<double> mean_square_;  // by function; below 0: not measured yet
  WeightingFunction function_;       // the one asked for last …
  int function_idx_ = -1;
  int valid_count_ = 0;
};

// One stage at work: offers better theta for some functions of a batch. It allocates nothing, once it is made.
class StageRun {
 public:
  virtual ~StageRun() = default;
  // members   indices into the batch, rising
  virtual void run(ThetaBatch& batch, const int* members, int member_count) = 0;
};

// By what an offer has to be better: below lies rounding, since sums in another order differ.
inline constexpr double kOfferPays = 0.999;

}  // namespace nlg
