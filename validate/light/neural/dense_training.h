// Dense networks in libtorch, as they are trained: their numbers are one flat tensor, in the order of DenseNetwork.
#pragma once

#include <torch/types.h>

#include <cstdint>

#include "validate/light/neural/dense_network.h"

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

}  // namespace nlg
