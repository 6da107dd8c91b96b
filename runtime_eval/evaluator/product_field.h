// Evaluates product fields: clamp(A(x), 0, 1) * sigmoid(B(x)), A and B trilinear in r³ nodes over [-1, 1]³ (the talk's second
// representation). Layout of the nodes in theta: nlg/representation.h. Positions outside the cube take the value at its
// border.
//
// Nodes up to ±1e37 give values in [0, 1]; where a node is no number, so are the values of its cells. The sigmoid is within 3
// units in the last place for |B| <= 87; below -87 it stays at 1.6e-38.
#pragma once

#include "runtime_eval/support/point_order.h"

namespace nlg {

// The field at any points.
// values   points.padded_count floats
// theta    2 r³ floats
void evaluateField(int resolution, const PointSet& points, const float* theta, float* values);

// The field at every place of a cell order, cell after cell: several times faster.
// values   order.placeCount() floats; at places without a point the value at the cell's centre
void evaluateFieldCells(const PointOrder& order, const float* theta, float* values);

// A field on a grid of another resolution: A and B at the new nodes. Where the new grid holds all nodes of the old one (3 to 5, 7
// and 9; 5 to 9) it is the same field, so that a fit can go on with more nodes where it had come to its end with few.
// theta    2 from³ floats
// result   2 to³ floats
void resampleField(int from, const float* theta, int to, float* result);

// In double, one point, straight from the formula: what the vector code is tested against.
double evaluateFieldReference(int resolution, const LocalPoint& point, const double* theta);

}  // namespace nlg
