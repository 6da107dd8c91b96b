// Losses and their gradients in double, straight from the formulas (docs/theory/math.md §4): what the vector code is tested against.
#pragma once

#include "nlg/representation.h"
#include "runtime_eval/support/point_order.h"

namespace nlg {

// As networkLossAndGradient.
double networkLossAndGradientReference(const Representation& representation, const PointSet& points, int first, int count,
                                       const float* phi, const float* mask, const double* theta, double* gradient);

// Of any network, whether or not it is one of kNetworks.
double networkLossAndGradientReference(const NetworkKind& network, double slope, const PointSet& points, int first, int count,
                                       const float* phi, const float* mask, const double* theta, double* gradient);

// One point: the field, and its derivatives by A and B of the 8 nodes of the point's cell.
// point   in [-1, 1]³
struct FieldDerivative {
  double value;
  int node[8];
  double by_a[8], by_b[8];
};
FieldDerivative fieldDerivativeReference(int resolution, const LocalPoint& point, const double* theta);

// As fieldLossAndGradient.
double fieldLossAndGradientReference(const PointOrder& order, const float* phi, const float* mask, const double* theta,
                                     double* gradient);

}  // namespace nlg
