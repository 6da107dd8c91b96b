#include "runtime_eval/fit/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/fit/last_layer.h"

namespace nlg {
namespace {

// Damping that follows how well the quadratic model predicted the last step (Nielsen 1999).
class Damping {
 public:
  explicit Damping(double start) : value_(start) {}
  double value() const { return value_; }
  void accepted(double gain) {
    const double t = 2.0 * gain - 1.0;
    value_ = std::max(1e-9, value_ * std::max(1.0 / 3.0, 1.0 - t * t * t));
    growth_ = 2.0;
  }
  void rejected() {
    value_ *= growth_;
    growth_ *= 2.0;
  }
  bool exhausted() const { return !(value_ < 1e12); }

 private:
  double value_, growth_ = 2.0;
};

// Damping of a diagonal entry is relative to it, and to this share of the largest one where that is more: parameters that hardly
// matter yet (units that are nearly dead) must not take steps of any length.
constexpr double kDampingFloor = 1e-3;

// The damped step, solved in `matrix`, whose memory is kept from step to step; empty when the system cannot be solved. Rows whose
// diagonal is nearly zero (dead units) get a floor, so that a rank-deficient Jacobian still gives a step.
std::vector<double> dampedStep(const NormalEquations& equations, double damping, SymmetricBand& matrix) {
  matrix = equations.hessian;
  const int count = matrix.count();
  std::vector<double> step(count);
  double largest = 0.0;
  for (int i = 0; i < count; ++i) largest = std::max(largest, matrix.at(i, i));
  for (int i = 0; i < count; ++i) {
    double& diagonal = matrix.at(i, i);
    diagonal += damping * std::max(diagonal, kDampingFloor * largest) + 1e-12;
    step[i] = -equations.gradient[i];
  }
  if (!matrix.solve(step.data())) step.clear();
  return step;
}

// How much the quadratic model says that the step lowers the sum of squares.
double predictedGain(const NormalEquations& equations, const std::vector<double>& step) {
  std::vector<double> product(step.size());
  equations.hessian.multiply(step.data(), product.data());
  double gain = 0.0;
  for (size_t i = 0; i < step.size(); ++i) gain -= step[i] * (2.0 * equations.gradient[i] + product[i]);
  return gain;
}

double largestMagnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) return INFINITY;
    largest = std::max(largest, std::fabs(value));
  }
  return largest;
}

FitResult runLevenbergMarquardt(const Representation& representation, const WeightingFunction& function, const Theta& start,
                                const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel) {
  FitResult result{start, functionRmse(representation, function, start.data()), 0, FitStop::budget};
  const int valid_count = function.validCount();
  if (valid_count == 0) {
    result.stop = FitStop::no_points;
    return result;
  }
  if (!std::isfinite(result.rmse)) {
    result.stop = FitStop::not_finite;
    return result;
  }
  NormalEquations equations;
  SymmetricBand damped;
  int next_batch = 0;
  const auto computeEquations = [&] {
    kernel->compute(representation, function, result.theta.data(), &equations, options.hessian_points, next_batch);
    next_batch += 3;  // prime to the number of batches: all take their turn
  };
  computeEquations();
  Damping damping(options.damping);
  double square_sum = result.rmse * result.rmse * valid_count;
  int slow_steps = 0;
  while (result.steps < options.iterations) {
    if (largestMagnitude(equations.gradient) < options.gradient_tolerance * valid_count) {
      result.stop = FitStop::gradient;
      break;
    }
    ++result.steps;
    const std::vector<double> step = dampedStep(equations, damping.value(), damped);
    Theta theta = result.theta;
    for (size_t i = 0; i < step.size(); ++i) theta[i] += static_cast<float>(step[i]);
    // the last layer is linear: for these hidden units there is nothing to iterate (when it cannot be solved the step stands
    // alone)
    if (!step.empty() && !representation.isField()) solveLastLayer(representation, function, theta.data());
    const double rmse = step.empty() ? INFINITY : functionRmse(representation, function, theta.data());
    const double next_sum = rmse * rmse * valid_count;
    if (!(next_sum < square_sum)) {
      damping.rejected();
      if (damping.exhausted()) {
        result.stop = FitStop::damping;
        break;
      }
      continue;
    }
    damping.accepted((square_sum - next_sum) / std::max(predictedGain(equations, step), 1e-300));
    slow_steps = square_sum - next_sum < options.progress_tolerance * square_sum ? slow_steps + 1 : 0;
    square_sum = next_sum;
    result.theta = theta;
    result.rmse = rmse;
    if (slow_steps == 3) {
      result.stop = FitStop::progress;
      break;
    }
    if (result.steps < options.iterations) computeEquations();
  }
  return result;
}

}  // namespace

LevenbergMarquardtOptions refinementLevenbergMarquardt(const Representation& representation, int iterations) {
  LevenbergMarquardtOptions options;
  options.iterations = iterations;
  options.damping = representation.isField() ? 0.01 : 0.1;
  return options;
}

FitResult fitLevenbergMarquardt(const Representation& representation, const WeightingFunction& function, const Theta& start,
                                const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel) {
  return timedFit([&] { return runLevenbergMarquardt(representation, function, start, options, kernel); });
}

}  // namespace nlg
