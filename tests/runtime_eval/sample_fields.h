// Product fields to test with, and how far float arithmetic may take them from the formula.
#pragma once

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {

inline LocalPoint placePosition(const PointOrder& order, int place) {
  return {order.points.x[place], order.points.y[place], order.points.z[place]};
}

// Every node at random: A in [low, high], B normal with deviation 2.
inline Theta randomField(int resolution, uint64_t seed, double low, double high) {
  Random random(seed);
  Theta theta(Representation::productField(resolution).thetaCount());
  for (size_t i = 0; i < theta.size(); i += 2) {
    theta[i] = static_cast<float>(random.uniform(low, high));
    theta[i + 1] = static_cast<float>(2.0 * random.normal());
  }
  return theta;
}

// The same A and B at all nodes.
inline Theta constantField(int resolution, float a, float b) {
  Theta theta(Representation::productField(resolution).thetaCount());
  for (size_t i = 0; i < theta.size(); i += 2) theta[i] = a, theta[i + 1] = b;
  return theta;
}

// Largest error of A (channel 0) or B (channel 1) at any point, nodes no larger than m.
//   Inside a cell: eight coefficients no larger than m, 3 roundings in each, 3 steps of 2 roundings to add them up.
//   At any point: per axis 2 roundings of a coordinate up to r - 1 and a slope up to 2 m a cell; 3 steps of interpolation with
//   3 roundings of up to 2 m each.
inline double trilinearError(int resolution, const Theta& theta, int channel) {
  double largest = 0.0;
  for (size_t i = channel; i < theta.size(); i += 2) largest = std::max(largest, std::fabs(static_cast<double>(theta[i])));
  const double inside = (3 + 6) * 8 * largest, anywhere = 3 * (2.0 * (resolution - 1)) * 2 * largest + 9 * 2 * largest;
  return kFloatRounding * std::max(inside, anywhere);
}

// Largest error of the field, and of its derivatives by A and B: those of A and B (the sigmoid's slope is at most 1/4, and its
// derivative's at most 1/4 as well), 6 roundings for the sigmoid's 3 units in the last place and 4 of the products.
inline double fieldError(int resolution, const Theta& theta) {
  return trilinearError(resolution, theta, 0) + trilinearError(resolution, theta, 1) / 4 + 10 * kFloatRounding;
}

// A at one point, before the clamp.
inline double unclampedA(int resolution, const LocalPoint& point, const Theta& theta) {
  double a = 0.0;
  for (int i = 0; i < resolution * resolution * resolution; ++i) {
    const int node[3] = {i % resolution, i / resolution % resolution, i / (resolution * resolution)};
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      weight *= std::max(0.0, 1.0 - std::fabs((static_cast<double>(point[axis]) + 1.0) * 0.5 * (resolution - 1) - node[axis]));
    }
    if (weight > 0.0) a += weight * theta[2 * i];
  }
  return a;
}

// Leaves out points whose A is within `margin` of the clamp: there float and double may take different derivatives.
inline void maskClamp(const PointOrder& order, const Theta& theta, double margin, AlignedFloats* mask) {
  for (int place = 0; place < order.placeCount(); ++place) {
    const double a = unclampedA(order.resolution, placePosition(order, place), theta);
    if (std::fabs(a) < margin || std::fabs(a - 1.0) < margin) (*mask)[place] = 0.0f;
  }
}

}  // namespace nlg
