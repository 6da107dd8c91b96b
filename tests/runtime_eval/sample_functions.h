// Weighting functions and theta to test with, and the yardsticks of rounding that the tests' bounds are derived from.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

// Half a unit in the last place of 1: the largest relative error of one float operation.
inline constexpr double kFloatRounding = 0x1p-24;

inline const Representation kBothRepresentations[] = {Representation::mlp(0.01f), Representation::tentMlp(0.01f),
                                                      Representation::mlp(0.3f)};

// Every network, and one of another slope.
inline const Representation kNetworkRepresentations[] = {Representation::mlp(0.01f),
                                                         Representation::tentMlp(0.01f),
                                                         Representation::mlp(0.3f),
                                                         {RepresentationKind::tent_mlp44, 0.01f},
                                                         {RepresentationKind::tent_mlp4, 0.01f},
                                                         {RepresentationKind::tent_mlp44, 0.3f}};
static_assert(kNetworkCount == 4, "kNetworkRepresentations holds them all");

struct StoredSample {
  std::vector<uint8_t> phi = std::vector<uint8_t>(kSupportPointCount, 0);
  std::vector<uint8_t> validity = std::vector<uint8_t>(kValidityByteCount, 0);
  std::vector<uint8_t> blend_sum;  // none: as if other probes saw whatever this one sees
  StoredFunction view() const { return {phi.data(), validity.data(), nullptr, blend_sum.empty() ? nullptr : blend_sum.data()}; }
  bool valid(int p) const { return validity[p / 8] >> (p % 8) & 1; }
};

// A function in the order of fits: all of its valid points count alike, unless a test is about the loss.
inline WeightingFunction decoded(const StoredFunction& stored, const PointOrder& order = stratumOrder(),
                                 const LossOptions& loss = kUnweighed) {
  return decodeFunction(stored, order, loss);
}

// Every byte at random.
inline StoredSample noiseSample(uint64_t seed) {
  Random random(seed);
  StoredSample sample;
  for (uint8_t& value : sample.phi) value = static_cast<uint8_t>(random.below(256));
  for (uint8_t& bits : sample.validity) bits = static_cast<uint8_t>(random.below(256));
  return sample;
}

// Points that count for 1, 3/4 and 1/2 in turn: a mask that weighs, not only leaves out.
inline void weigh(AlignedFloats* mask) {
  for (size_t i = 0; i < mask->size(); ++i) (*mask)[i] *= 1.0f - 0.25f * static_cast<float>(i % 3);
}

// A probe beside a wall: the tent on this side of a random plane, nothing on the other, solid in between.
inline StoredSample wallSample(uint64_t seed) {
  Random random(seed);
  double normal[3], length = 0.0;
  for (double& n : normal) n = random.normal(), length += n * n;
  const double offset = random.uniform(0.1, 0.6), thickness = random.uniform(0.05, 0.2);
  StoredSample sample;
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = supportPattern().points[p];
    double distance = -offset;
    for (int axis = 0; axis < 3; ++axis) distance += normal[axis] / std::sqrt(length) * point[axis];
    if (distance < 0) sample.phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(point)));
    if (distance < 0 || distance > thickness) sample.validity[p / 8] |= static_cast<uint8_t>(1 << (p % 8));
  }
  return sample;
}

// The same where other probes see some of it: sums of the blend from what this one has to 1.
inline StoredSample crowdedSample(uint64_t seed) {
  StoredSample sample = wallSample(seed);
  Random random(seed + 1000);
  for (int p = 0; p < kSupportPointCount; ++p) {
    const uint32_t others = random.below(256);
    sample.blend_sum.push_back(sample.phi[p] == 0 ? 255 : static_cast<uint8_t>(std::max<uint32_t>(sample.phi[p], others)));
  }
  return sample;
}

inline std::vector<double> toDouble(const Theta& theta) { return {theta.begin(), theta.end()}; }

// The same with every number positive. A network of such numbers adds up the magnitudes of all terms of the original: no
// leaky unit is below zero, nothing cancels. Rounding errors are a small multiple of what it computes.
inline std::vector<double> magnitudes(const Theta& theta) {
  std::vector<double> result;
  for (const float value : theta) result.push_back(std::fabs(value));
  return result;
}
// What adds up the magnitudes of all terms of a representation: itself when its output is linear. An output function of slope 1 or
// less and values up to 1 adds nothing to the error of its sum, nor does a tent factor: there it is the network without either,
// whose sum is 1 or more. (The derivative s (1 - s) of a sigmoid changes by .1 of what its sum changes by: with phi and tent up to
// 1 the product with the residual is within it.)
inline NetworkKind magnitudeNetwork(const Representation& representation) {
  NetworkKind network = representation.network();
  if (network.shape.output != OutputFunction::linear) {
    network.shape.output = OutputFunction::linear;
    network.tent_factor = false;
  }
  return network;
}
inline std::vector<double> magnitudes(const Representation& representation, const Theta& theta) {
  std::vector<double> result = magnitudes(theta);
  if (representation.shape().output != OutputFunction::linear) result[representation.shape().b3()] += 1.0;
  return result;
}
inline LocalPoint magnitudes(const LocalPoint& point) { return {std::fabs(point[0]), std::fabs(point[1]), std::fabs(point[2])}; }
inline PointSet magnitudes(PointSet points) {
  for (AlignedFloats* values : {&points.x, &points.y, &points.z}) {
    for (float& value : *values) value = std::fabs(value);
  }
  return points;
}
// phi enters the residual with a minus: negative, it adds to the output.
inline AlignedFloats negated(AlignedFloats values) {
  for (float& value : values) value = -std::fabs(value);
  return values;
}

// How far the nearest of the hidden units is from its kink.
inline double kinkDistance(const Representation& representation, const LocalPoint& point, const std::vector<double>& theta) {
  const NetworkShape& shape = representation.shape();
  double nearest = std::numeric_limits<double>::max();
  std::vector<double> values(point.begin(), point.end());
  const auto layer = [&](int width, int weights, int biases) {
    std::vector<double> next(width);
    for (int j = 0; j < width; ++j) {
      double sum = theta[biases + j];
      for (size_t i = 0; i < values.size(); ++i) sum += theta[weights + j * values.size() + i] * values[i];
      nearest = std::min(nearest, std::fabs(sum));
      next[j] = sum > 0 ? sum : representation.slope * sum;
    }
    values = next;
  };
  layer(shape.first, shape.w1(), shape.b1());
  if (shape.second > 0) layer(shape.second, shape.w2(), shape.b2());
  return nearest;
}

// Leaves out points at which a unit is within `margin` of its kink: there float and double may take different derivatives, and
// a finite difference takes both.
inline void maskKinks(const Representation& representation, const PointSet& points, const Theta& theta, double margin,
                      AlignedFloats* mask) {
  const std::vector<double> exact = toDouble(theta);
  for (int i = 0; i < points.count; ++i) {
    if (kinkDistance(representation, {points.x[i], points.y[i], points.z[i]}, exact) < margin) (*mask)[i] = 0.0f;
  }
}

inline StoredSample tentSample() {
  StoredSample sample;
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{255});
  for (int p = 0; p < kSupportPointCount; ++p) {
    sample.phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
  }
  return sample;
}

// NaN counts as equal to the same NaN.
inline bool sameBits(const Theta& a, const Theta& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace nlg
