#include "runtime_eval/policy/theta_batch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/loss/loss_kernel.h"
#include "runtime_eval/numbers/finite.h"

namespace nlg {
namespace {

constexpr double kNotMeasured = -1.0;

// A last layer solved on few points may have numbers of any size.
bool canBeStored(const Representation& representation, const float* theta) {
  float rounded[kMaxThetaCount];
  std::copy_n(theta, representation.thetaCount(), rounded);
  return roundTheta(representation, ThetaPrecision::float16, rounded) &&
         roundTheta(representation, ThetaPrecision::int8, rounded);
}

}  // namespace

ThetaBatch::ThetaBatch(const Generator& generator, const LossOptions& loss)
    : generator_(&generator),
      theta_count_(static_cast<size_t>(generator.representation().thetaCount())),
      loss_(loss),
      scratch_(generator),
      mean_square_(kBatchCount) {
  const PointOrder& order = pointOrder(generator.representation());
  function_.phi.resize(order.placeCount());
  function_.mask.resize(order.placeCount());
  function_.valid_count.resize(order.batchCount());
}

void ThetaBatch::generate(const StoredFunction* functions, int count, float* theta, Begin begin) {
  functions_ = functions;
  count_ = count;
  theta_ = theta;
  function_idx_ = -1;
  std::fill(mean_square_.begin(), mean_square_.end(), kNotMeasured);
  if (begin == Begin::theta0) {
    for (int i = 0; i < count; ++i)
      std::copy_n(generator_->theta0(), theta_count_, theta + static_cast<size_t>(i) * theta_count_);
    return;
  }
  generator_->generate(functions, count, theta, &scratch_);
}

const WeightingFunction& ThetaBatch::function(int i) {
  if (function_idx_ == i) return function_;
  decodeFunction(functions_[i], pointOrder(representation()), loss_, &function_);
  valid_count_ = function_.validCount();
  function_idx_ = i;
  return function_;
}

double ThetaBatch::meanSquareOf(const float* theta) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (valid_count_ == 0 || !allFinite({theta, theta_count_})) return kInfinite;
  const int place_count = static_cast<int>(function_.phi.size());
  const double sum = loss(representation(), 0, place_count, function_.phi.data(), function_.mask.data(), theta);
  return std::isfinite(sum) ? sum / valid_count_ : kInfinite;
}

double ThetaBatch::meanSquare(int i) {
  if (mean_square_[i] < 0.0) {
    function(i);
    mean_square_[i] = meanSquareOf(theta(i));
  }
  return mean_square_[i];
}

bool ThetaBatch::offer(int i, const float* theta, double mean_square, double share) {
  if (!(mean_square < share * meanSquare(i)) || !canBeStored(representation(), theta)) return false;
  // sums of another kernel may say that a theta is better than itself
  if (std::memcmp(theta, this->theta(i), theta_count_ * sizeof(float)) == 0) return false;
  set(i, theta, mean_square);
  return true;
}

void ThetaBatch::putBack(int i, const float* theta) { set(i, theta, kNotMeasured); }

void ThetaBatch::set(int i, const float* theta, double mean_square) {
  std::copy_n(theta, theta_count_, theta_ + static_cast<size_t>(i) * theta_count_);
  mean_square_[i] = mean_square;
}

}  // namespace nlg
