// Irradiance by one dense network that reads position and normal and nothing else: what voxels hold, and a sine network a whole scene.
#pragma once

#include <cstdint>
#include <vector>

#include "validate/light/neural/dense_network.h"
#include "validate/light/neural/learner.h"
#include "validate/light/neural/light_samples.h"

namespace nlg {

enum class DenseCode {
  plain,      // outputs are irradiance over the unit; the loss is symmetricShares
  logarithm,  // … ln(10 x + 1) of it; the loss is the mean square: the target of SIREN GI, without its albedo
};

// The network's answer as irradiance over the unit, >= 0.
float decoded(DenseCode code, float output);

// samples   what is learned
// *record   what training took
// returns   the network's numbers, not rounded
std::vector<float> trainDense(const LightSamples& samples, const DenseShape& shape, DenseCode code, int64_t batch,
                              const TrainingOptions& options, TrainingRecord* record);

}  // namespace nlg
