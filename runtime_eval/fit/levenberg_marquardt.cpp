#include "runtime_eval/fit/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/numbers/flush_subnormals.h"

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

double largestMagnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) return INFINITY;
    largest = std::max(largest, std::fabs(value));
  }
  return largest;
}

}  // namespace

class LevenbergMarquardt {
 public:
  LevenbergMarquardt(const Representation& representation, const WeightingFunction& function,
                     const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel,
                     LevenbergMarquardtWorkspace* workspace)
      : representation_(representation), function_(function), options_(options), kernel_(kernel), workspace_(*workspace) {}

  FitResult run(float* theta) {
    const size_t count = static_cast<size_t>(representation_.thetaCount());
    FitResult result{{}, functionRmse(representation_, function_, theta), 0, FitStop::budget};
    const int valid_count = function_.validCount();
    if (valid_count == 0) {
      result.stop = FitStop::no_points;
      return result;
    }
    if (!std::isfinite(result.rmse)) {
      result.stop = FitStop::not_finite;
      return result;
    }
    const NormalEquations& equations = workspace_.equations_;
    Theta& trial = workspace_.trial_;
    computeEquations(theta);
    Damping damping(options_.damping);
    double square_sum = result.rmse * result.rmse * valid_count;
    int slow_steps = 0;
    // Nielsen's loop (docs/theory/math.md §5): a rejected step is tried again on the same equations with more damping
    while (result.steps < options_.iterations) {
      // the tolerance is of the mean over valid points
      if (largestMagnitude(equations.gradient) < options_.gradient_tolerance * valid_count) {
        result.stop = FitStop::gradient;
        break;
      }
      ++result.steps;
      const bool is_solved = solveStep(damping.value());
      trial.assign(theta, theta + count);
      for (size_t i = 0; is_solved && i < count; ++i) trial[i] += static_cast<float>(workspace_.step_[i]);
      // the last layer is linear: for these hidden units there is nothing to iterate (when it cannot be solved the step stands
      // alone)
      if (is_solved && !representation_.isField()) {
        solveLastLayer(representation_, 0, static_cast<int>(function_.phi.size()), function_.phi.data(), function_.mask.data(),
                       trial.data(), &workspace_.last_layer_, 0.0);
      }
      // a system that cannot be solved, or a NaN, counts as a step that gains nothing
      const double rmse = is_solved ? functionRmse(representation_, function_, trial.data()) : INFINITY;
      const double next_sum = rmse * rmse * valid_count;
      if (!(next_sum < square_sum)) {
        damping.rejected();
        if (damping.exhausted()) {
          result.stop = FitStop::damping;
          break;
        }
        continue;
      }
      // gain: how much the sum of squares fell, over what the quadratic model had predicted
      damping.accepted((square_sum - next_sum) / std::max(predictedGain(), 1e-300));
      slow_steps = square_sum - next_sum < options_.progress_tolerance * square_sum ? slow_steps + 1 : 0;
      square_sum = next_sum;
      std::copy(trial.begin(), trial.end(), theta);
      result.rmse = rmse;
      if (slow_steps == 3) {
        result.stop = FitStop::progress;
        break;
      }
      // for networks H now sums other strata, so that all of them have their turn
      if (result.steps < options_.iterations) computeEquations(theta);
    }
    return result;
  }

 private:
  void computeEquations(const float* theta) {
    kernel_->compute(representation_, function_, theta, &workspace_.equations_, options_.hessian_points, next_batch_);
    next_batch_ += 3;  // prime to the number of batches: all take their turn
  }

  // The damped step; false when the system cannot be solved. Rows whose diagonal is nearly zero (dead units) get a floor, so that a
  // rank-deficient Jacobian still gives a step.
  bool solveStep(double damping) {
    SymmetricBand& matrix = workspace_.damped_;
    matrix = workspace_.equations_.hessian;
    const int count = matrix.count();
    workspace_.step_.resize(count);
    double largest = 0.0;
    for (int i = 0; i < count; ++i) largest = std::max(largest, matrix.at(i, i));
    for (int i = 0; i < count; ++i) {
      double& diagonal = matrix.at(i, i);
      diagonal += damping * std::max(diagonal, kDampingFloor * largest) + 1e-12;
      workspace_.step_[i] = -workspace_.equations_.gradient[i];
    }
    return matrix.solve(workspace_.step_.data());
  }

  // How much the quadratic model says that the step lowers the sum of squares.
  double predictedGain() {
    const std::vector<double>& step = workspace_.step_;
    workspace_.product_.resize(step.size());
    workspace_.equations_.hessian.multiply(step.data(), workspace_.product_.data());
    double gain = 0.0;
    for (size_t i = 0; i < step.size(); ++i) {
      gain -= step[i] * (2.0 * workspace_.equations_.gradient[i] + workspace_.product_[i]);
    }
    return gain;
  }

  const Representation& representation_;
  const WeightingFunction& function_;
  const LevenbergMarquardtOptions& options_;
  NormalEquationsKernel* kernel_;
  LevenbergMarquardtWorkspace& workspace_;
  int next_batch_ = 0;
};

LevenbergMarquardtOptions refinementLevenbergMarquardt(const Representation& representation, int iterations) {
  LevenbergMarquardtOptions options;
  options.iterations = iterations;
  options.damping = representation.isField() ? 0.01 : 0.1;
  return options;
}

LevenbergMarquardtOptions longLevenbergMarquardt(const Representation& representation, int iterations) {
  // for 64 usual numbers a mean square of a sixteenth of what bytes of phi are off by
  constexpr double kWeakPrior = 1e-5;
  LevenbergMarquardtOptions options = refinementLevenbergMarquardt(representation, iterations);
  options.code_prior = kWeakPrior;
  options.code_all_points = true;
  return options;
}

FitResult iterateLevenbergMarquardt(const Representation& representation, const WeightingFunction& function,
                                    const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel,
                                    LevenbergMarquardtWorkspace* workspace, float* theta) {
  const FlushSubnormals flush;
  if (representation.isCode()) {
    const CodeFitOptions code{.iterations = options.iterations,
                              .damping = options.damping,
                              .prior = options.code_prior,
                              .progress_tolerance = options.progress_tolerance,
                              .all_points = options.code_all_points};
    return workspace->code_.iterate(representation, function, code, representation.code_count, theta);
  }
  return LevenbergMarquardt(representation, function, options, kernel, workspace).run(theta);
}

FitResult fitLevenbergMarquardt(const Representation& representation, const WeightingFunction& function, const Theta& start,
                                const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel) {
  return timedFit([&] {
    LevenbergMarquardtWorkspace workspace;
    Theta theta = start;
    FitResult result = iterateLevenbergMarquardt(representation, function, options, kernel, &workspace, theta.data());
    result.theta = std::move(theta);
    return result;
  });
}

}  // namespace nlg
