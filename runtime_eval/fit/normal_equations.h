// Builds the normal equations of one theta against one weighting function, for Levenberg–Marquardt.
#pragma once

#include <vector>

#include "nlg/representation.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

struct NormalEquations {
  SymmetricBand hessian;         // D x D: sum over valid points of J^T J, J = d representation / d theta
  std::vector<double> gradient;  // D: sum of J^T r; half the gradient of the loss
  double square_sum = 0.0;       // sum of r², as lossAndGradient returns it
};

// Keeps its workspace between calls; NormalEquations keep theirs while the representation stays the same.
//
// Gradient and sum of squares are over all support points; so is the Hessian of a product field. That of a network costs 6,600
// multiply-adds a point, most of a Levenberg–Marquardt iteration, and only steers the step: it may be summed over some of the
// batches of points and scaled up to all. Products are summed in float over 1024 points, then in double.
class NormalEquationsKernel {
 public:
  NormalEquationsKernel();

  // hessian_points   batches are taken, from number `first_batch` on and round, until they hold so many valid points
  void compute(const Representation& representation, const WeightingFunction& function, const float* theta,
               NormalEquations* equations, int hessian_points = kSupportPointCount, int first_batch = 0);

 private:
  void computeNetwork(const Representation& representation, const WeightingFunction& function, const float* theta,
                      int hessian_points, int first_batch, NormalEquations* equations);

  AlignedFloats jacobian_;  // rows of one stratum: D derivatives and the residual
};

// Builds the normal equations of one theta of a product field against one weighting function.
//
// A point depends on the 8 nodes of its cell, so that J^T J is a band: nodes are numbered x fastest, and those of one cell lie at
// most 1 + r + r² apart.
//
// order      cellOrder(r); function is in it
// theta      2 r³ floats
// equations  hessian of 2 r³ rows and bandwidth 2 (1 + r + r²) + 1
void fieldNormalEquations(const PointOrder& order, const WeightingFunction& function, const float* theta,
                          NormalEquations* equations);

}  // namespace nlg
