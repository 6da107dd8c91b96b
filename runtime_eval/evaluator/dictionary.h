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

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "nlg/representation.h"
#include "runtime_eval/support/point_order.h"

namespace nlg {

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

// sigmoid(L) at a point, which is limited to the cube.
// brick   r³ steps
float evaluateBrick(int resolution, const LocalPoint& point, float step, const int8_t* brick);

// The same of a code whose brick is nowhere: made for this one point.
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

}  // namespace nlg
