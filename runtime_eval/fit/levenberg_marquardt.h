// Fits theta by Levenberg–Marquardt (Marquardt 1963, Nielsen's damping 1999) on all support points.
#pragma once

#include "runtime_eval/fit/code_fit.h"
#include "runtime_eval/fit/normal_equations.h"

namespace nlg {

struct LevenbergMarquardtOptions {
  int iterations = 20;
  double damping = 0.1;              // at the start, relative to the diagonal of J^T J
  int hessian_points = 2000;         // networks: valid points that J^T J is summed over, other ones in every iteration
  double gradient_tolerance = 1e-9;  // ends when max |J^T r| / valid points falls below
  double progress_tolerance = 1e-6;  // ends when three accepted iterations in a row lower the loss by less than this share
  double code_prior = CodeFitOptions().prior;          // codes (code_fit.h)
  bool code_all_points = CodeFitOptions().all_points;  // the same
};

// Damping that measured best for a start near the solution (docs/lab/measurements.md).
LevenbergMarquardtOptions refinementLevenbergMarquardt(const Representation& representation, int iterations);

// … of a fit that is a yardstick and may take its time: of codes it takes all points, and a prior so weak that it costs nothing.
LevenbergMarquardtOptions longLevenbergMarquardt(const Representation& representation, int iterations);

// What iterations keep between each other; from one function to the next of the same representation it allocates nothing.
class LevenbergMarquardtWorkspace {
 private:
  friend class LevenbergMarquardt;
  friend FitResult iterateLevenbergMarquardt(const Representation&, const WeightingFunction&, const LevenbergMarquardtOptions&,
                                             NormalEquationsKernel*, LevenbergMarquardtWorkspace*, float*);
  NormalEquations equations_;
  SymmetricBand damped_, last_layer_;
  std::vector<double> step_, product_;
  Theta trial_;
  CodeFit code_;
};

// Iterates in place.
// theta      D floats; every accepted step lowers the loss, so the result is never worse than the start
// returns    rmse, steps and stop of the fit, without its theta
FitResult iterateLevenbergMarquardt(const Representation& representation, const WeightingFunction& function,
                                    const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel,
                                    LevenbergMarquardtWorkspace* workspace, float* theta);

// Fits theta to the function from `start`; every accepted step lowers the loss, so the result is never worse than the start.
FitResult fitLevenbergMarquardt(const Representation& representation, const WeightingFunction& function, const Theta& start,
                                const LevenbergMarquardtOptions& options, NormalEquationsKernel* kernel);

}  // namespace nlg
