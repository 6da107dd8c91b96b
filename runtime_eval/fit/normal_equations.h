// Normal equations of one theta against one weighting function: what Levenberg–Marquardt solves.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/representation.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

struct NormalEquations {
  SymmetricBand hessian;         // D x D: sum over valid points of J^T J, J = d representation / d theta
  std::vector<double> gradient;  // D: sum of J^T r; half the gradient of the loss
  double square_sum = 0.0;       // sum of r², as lossAndGradient returns it
};

// Over all support points. Products are summed in float over 1024 points, then in double. About 57 million multiply-adds.
// workspace   kept between calls so that none of them allocates
class NormalEquationsKernel {
 public:
  NormalEquationsKernel();
  void compute(const Representation& representation, const WeightingFunction& function, const float* theta,
               NormalEquations* equations);

 private:
  AlignedFloats jacobian_;  // rows of one stratum: D derivatives and the residual, kStratumPointCount each
};

}  // namespace nlg
