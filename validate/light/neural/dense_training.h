// Trains dense networks in libtorch: their numbers are one flat tensor, in the order of DenseNetwork.
#pragma once

#include <cstdint>
#include <vector>

#include <torch/types.h>

#include "validate/light/neural/dense_network.h"
#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

// relu: normal with variance 2 / inputs (He et al., 2015). sine: that of the source, uniform within 1 / inputs in the first layer and
// within √(6 / inputs) behind it. Biases are 0, of sine networks uniform within 1 / √inputs. Takes gradients.
torch::Tensor initialParameters(const DenseShape& shape, uint64_t seed);

// Of one network, or of N of one shape, each with a batch of its own.
//
// parameters   P, or N x P
// input        B x widths.front(), or N x B x widths.front()
// returns      B x widths.back(), or N x B x widths.back()
torch::Tensor evaluateBatch(const DenseShape& shape, const torch::Tensor& parameters, torch::Tensor input);

std::vector<float> floatsOf(const torch::Tensor& flat);

// Irradiance by one dense network that reads position and normal and nothing else: what voxels hold, and a sine network a whole scene.
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
