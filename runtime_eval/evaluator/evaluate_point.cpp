#include "runtime_eval/evaluator/evaluate.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/logistic.h"

namespace nlg {
namespace {

float leaky(float value, float slope) { return std::max(value, slope * value); }

template <NetworkShape kShape>
float evaluateNetwork(float slope, const LocalPoint& point, const float* theta) {
  float first[kShape.first];
  for (int j = 0; j < kShape.first; ++j) {
    const float* w1 = theta + kShape.w1() + 3 * j;
    first[j] = leaky(theta[kShape.b1() + j] + w1[0] * point[0] + w1[1] * point[1] + w1[2] * point[2], slope);
  }
  float output = theta[kShape.b3()];
  // one hidden layer leads straight to the output
  if constexpr (kShape.second == 0) {
    for (int j = 0; j < kShape.first; ++j) output += theta[kShape.w3() + j] * first[j];
  }
  for (int j = 0; j < kShape.second; ++j) {
    const float* w2 = theta + kShape.w2() + kShape.first * j;
    // two chains, each half as long
    float even = theta[kShape.b2() + j], odd = 0.0f;
    for (int i = 0; i < kShape.first; i += 2) {
      even += w2[i] * first[i];
      odd += w2[i + 1] * first[i + 1];
    }
    output += theta[kShape.w3() + j] * leaky(even + odd, slope);
  }
  if constexpr (kShape.output == OutputFunction::sigmoid) return logistic(output);
  return output;
}

// theta holds pairs (A, B); x is the fastest axis of the nodes
float evaluateFieldPoint(int resolution, const LocalPoint& point, const float* theta) {
  const auto [node, share] = placeAmongNodes(resolution, point);
  const float* low = theta + 2 * ((node[2] * resolution + node[1]) * resolution + node[0]);
  float a = 0.0f, b = 0.0f;
  for (int zy = 0; zy < 4; ++zy) {
    const float weight = (zy & 1 ? share[1] : 1.0f - share[1]) * (zy >> 1 ? share[2] : 1.0f - share[2]);
    const float* pair = low + 2 * ((zy >> 1) * resolution + (zy & 1)) * resolution;
    a += weight * ((1.0f - share[0]) * pair[0] + share[0] * pair[2]);
    b += weight * ((1.0f - share[0]) * pair[1] + share[0] * pair[3]);
  }
  return std::clamp(a, 0.0f, 1.0f) * logistic(b);
}

// Without the tent as a factor.
float evaluateOutput(const Representation& representation, const LocalPoint& point, const float* theta) {
  if (representation.isCode()) return evaluateCode(*representation.dictionary, point, theta);
  if (representation.isField()) return evaluateFieldPoint(representation.resolution, point, theta);
  return withNetworkShape(representation,
                          [&]<NetworkShape kShape>() { return evaluateNetwork<kShape>(representation.slope, point, theta); });
}

}  // namespace

float evaluatePoint(const Representation& representation, const LocalPoint& point, const float* theta) {
  const float output = evaluateOutput(representation, point, theta);
  return representation.tentFactor() ? output * tent(point) : output;
}

float evaluateTentShare(const Representation& representation, const LocalPoint& point, float tent, const float* theta) {
  const float output = evaluateOutput(representation, point, theta);
  const float most = representation.tentFactor() ? 1.0f : tent;
  // as the comparisons are written, NaN has none, and nothing is divided by a tent of 0
  return output > 0.0f ? (output < most ? output / most : 1.0f) : 0.0f;
}

}  // namespace nlg
