// Lighting blended from probes by weighting functions, and the probes that make the best of given functions.
#pragma once

#include "validate/solved/light_field.h"

namespace nlg {

// N x 8: the weights of the probes around each point, >= 0; 0 for a probe that is not there.
using BlendWeights = std::vector<std::array<float, kCornerCount>>;

// Every point's weights divided by their sum; points whose sum is below 1e-6 keep zeros: no probe lights them.
BlendWeights normalised(const BlendWeights& weights);

// N: 1 at the points of these uses, 0 at others.
std::vector<float> pointsOf(const SamplePoints& points, std::initializer_list<PointUse> uses);

// Probe values that minimise the squared error of the blend over the points, for each signal by itself (linear least
// squares by Cholesky, with a ridge of 1e-7 of the mean diagonal so that probes without any weight get 0).
//
// weights   N x 8, normalised
// counts    N, >= 0: how much the error at each point counts
// returns   probes x S, row-major
std::vector<float> solveProbes(const SamplePoints& points, const BlendWeights& weights, const Signals& signals,
                               const std::vector<float>& counts);

// The blend at one point: S numbers to `out`.
void blend(const std::array<int, kCornerCount>& probe, const std::array<float, kCornerCount>& weights,
           const std::vector<float>& probes, int signal_count, float* out);

// N: mean over signals of the squared error at each point.
std::vector<double> squaredErrors(const SamplePoints& points, const BlendWeights& weights, const std::vector<float>& probes,
                                  const Signals& signals);

}  // namespace nlg
