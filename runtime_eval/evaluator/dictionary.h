// The dictionary that codes share: it turns a code of K numbers z into the logits of a weighting function.
//
//     phi(x) ≈ tent(x) * sigmoid(L(x)),   L trilinear in r³ nodes that cover [-1, 1]³,   L_n = c_n + sum over k of z_k b_kn
//
// The nodes L_n are a *brick*. A brick holds bytes: whole steps of 2^e from -127 to 127, e the least from -4 on for which the largest
// |L_n| of the code fits. That rounding is part of the formula, whoever evaluates it. c and b are bytes times a power of two for each k, and
// a stored code is bytes times one more: every product is exact in float. Summed up in the order of k, every machine and language has the same
// brick. The b_k are ordered: a code may end early, and what it lacks is 0.
//
// A dictionary is learned with its generator (train/generator), once for all probes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "nlg/representation.h"
#include "nlg/support.h"
#include "runtime_eval/support/point_order.h"

namespace nlg {

// The cell of r³ nodes over [-1, 1]³, of a product field or a brick, that holds a point, and the point's share of the way through it.
template <class Real>
struct NodePlace {
  int node[3];  // at the cell's low corner, 0 … r - 2
  Real share[3];
};

// The point is limited to the cube; what is no number lies in the first cell.
template <class Real = float>
NodePlace<Real> placeAmongNodes(int resolution, const LocalPoint& point) {
  NodePlace<Real> place;
  for (int axis = 0; axis < 3; ++axis) {
    const Real position = std::clamp((Real{point[axis]} + 1) * Real{0.5f}, Real{0}, Real{1}) * static_cast<Real>(resolution - 1);
    place.node[axis] = position > 0 ? std::min(static_cast<int>(position), resolution - 2) : 0;
    place.share[axis] = position - static_cast<Real>(place.node[axis]);
  }
  return place;
}

// Calls visit(node, weight) for the eight nodes of the cell, x fastest, with their trilinear weights.
template <class Real, class Visit>
void forEachNode(const NodePlace<Real>& place, int resolution, const Visit& visit) {
  for (int corner = 0; corner < 8; ++corner) {
    Real weight = 1;
    int node = 0, stride = 1;
    for (int axis = 0; axis < 3; ++axis, stride *= resolution) {
      const int high = corner >> axis & 1;
      weight *= high ? place.share[axis] : 1 - place.share[axis];
      node += (place.node[axis] + high) * stride;
    }
    visit(node, weight);
  }
}

inline constexpr int kMaxCodeCount = 128;
inline constexpr int kMaxBrickResolution = 9;
inline constexpr size_t kMaxBrickNodes = size_t{kMaxBrickResolution} * kMaxBrickResolution * kMaxBrickResolution;
// Floats from one row of nodes to the next: whole vectors, and one of zeros behind the last node, since kernels read past it.
constexpr size_t brickStride(size_t node_count) { return (node_count + 15) / 16 * 16 + 16; }
inline constexpr size_t kMaxBrickStride = brickStride(kMaxBrickNodes);
inline constexpr int kLeastStepExponent = -4;  // of a brick: a 16th of a logit
inline constexpr int kMostLogitSteps = 127;
inline constexpr int kMostCodeSteps = 127;  // of a stored code (theta_form.h)

// The numbers of a dictionary as files hold them.
struct DictionaryData {
  int resolution = 0;             // r: 3, 5, 7 or 9
  int code_count = 0;             // K: 8 … 128, a multiple of 8
  std::vector<int8_t> nodes;      // K + 1 rows of r³, x fastest: b_0 … b_{K-1}, c; in units of 2^exponent of their row
  std::vector<int8_t> exponents;  // K + 1
  std::vector<float> deviations;  // K, > 0: of the codes of a training set, as a fit's prior knows them

  bool operator==(const DictionaryData&) const = default;
};

// An empty text, or what is wrong: sizes, ranges, deviations.
std::string whatIsWrong(const DictionaryData& data);

class Dictionary {
 public:
  // data   nothing is wrong with it
  explicit Dictionary(DictionaryData data);
  Dictionary(const Dictionary&) = delete;
  Dictionary& operator=(const Dictionary&) = delete;

  const DictionaryData& data() const { return data_; }
  int resolution() const { return data_.resolution; }
  int codeCount() const { return data_.code_count; }
  int nodeCount() const { return data_.resolution * data_.resolution * data_.resolution; }
  const float* deviations() const { return data_.deviations.data(); }

  // Row k: b_k at the nodes, nodeStride() floats of which those behind the last node are 0; row K is c.
  const float* row(int k) const { return &rows_[static_cast<size_t>(k) * node_stride_]; }
  size_t nodeStride() const { return node_stride_; }

  // What fits need, made when it is first asked for.
  struct FitTables {
    AlignedFloats
        at_places;  // b at the support points: by place of cellOrder(resolution()), K floats each, 0 at places without one
    AlignedFloats tent_squares;  // K x K: sum over the support points of tent² b b^T
  };
  const FitTables& fitTables() const;

 private:
  DictionaryData data_;
  size_t node_stride_;
  AlignedFloats rows_;
  mutable std::once_flag made_;
  mutable FitTables fit_tables_;
};

// Logits of a code at the nodes, not rounded: c, then one product after another in the order of k.
// z        count floats: those behind are taken as 0
// logits   dictionary.nodeStride() floats, the last of them 0
void expandCode(const Dictionary& dictionary, const float* z, int count, float* logits);

// The step of a brick that holds these logits; not finite where they are not.
// count   a multiple of 16
float stepOfLogits(size_t count, const float* logits);

// Both, and rounds to steps: what a brick holds of a code of K numbers.
void roundedLogits(const Dictionary& dictionary, const float* z, float* logits);

// The brick of a code: r³ steps.
// z         finite
// returns   the step
float packBrick(const Dictionary& dictionary, const float* z, int8_t* brick);

// sigmoid(L) at a point, which is limited to the cube, of a code whose brick is nowhere: made for this one point.
float evaluateCode(const Dictionary& dictionary, const LocalPoint& point, const float* z);

// tent * sigmoid(L) in double, straight from the formulas: what the vector code is tested against.
double evaluateCodeReference(const Dictionary& dictionary, const LocalPoint& point, const double* z);

// tent * sigmoid(L) at any points, of logits that are rounded already.
// logits   of expandCode's size
// values   points.padded_count floats
void evaluateLogits(int resolution, const PointSet& points, const float* logits, float* values);

// The same at every place of a cell order, cell after cell: several times faster.
// values   order.placeCount() floats
void evaluateLogitCells(const PointOrder& order, const float* logits, float* values);

// Layout of a brick of logits for look-ups on CPUs and in shaders: two neighbouring words hold the eight nodes
// of a cell.
//
// Word x + r * (y + (r - 1) * z) holds four nodes, from its lowest byte on: (x, y, z), (x, y + 1, z), (x, y, z + 1), (x, y + 1, z + 1);
// x below r, y and z below r - 1. Three times the bytes of the brick, and one line of the cache where a brick has four rows in three.

// Words of one brick.
constexpr size_t quadCount(int resolution) {
  const auto r = static_cast<size_t>(resolution);
  return r * (r - 1) * (r - 1);
}
inline constexpr size_t kMaxQuads = quadCount(kMaxBrickResolution);

// brick   r³ steps, as packBrick gives them
// quads   quadCount(resolution) words
void packQuads(int resolution, const int8_t* brick, uint32_t* quads);

// sigmoid(L) at a point, which is limited to the cube.
float evaluateQuads(int resolution, const LocalPoint& point, float step, const uint32_t* quads);

}  // namespace nlg
