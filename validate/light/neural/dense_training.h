// Trains dense networks in libtorch: their numbers are one flat tensor, in the order of DenseNetwork.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <torch/types.h>

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

// A small dense network for look-ups: plain loops, no library.

enum class Activation {
  relu,
  sine,  // sin(w (x W + b)), w of the first layer alone other than 1: Sitzmann et al., "Implicit Neural Representations with
         // Periodic Activation Functions" (NeurIPS 2020)
};

struct DenseShape {
  std::vector<int> widths;  // inputs, hidden layers, outputs: at least two; each in [1, kMostWidth]
  Activation activation = Activation::relu;
  float first_frequency = 1.0f;  // w of a sine network's first layer

  static constexpr int kMostWidth = 512;
  size_t layerCount() const { return widths.size() - 1; }
  size_t parameterCount() const;
  size_t multiplyAdds() const;  // of a look-up
};

// parameters   a layer after another: its matrix, inputs x outputs, row-major, then its outputs' biases
class DenseNetwork {
 public:
  DenseNetwork(DenseShape shape, std::vector<float> parameters);
  // input    widths.front()
  // output   widths.back()
  // Any number of threads may ask at once.
  void evaluate(const float* input, float* output) const;
  const DenseShape& shape() const { return shape_; }
  const std::vector<float>& parameters() const { return parameters_; }

 private:
  DenseShape shape_;
  std::vector<float> parameters_;
};

// Each number as float16 holds it; what is beyond float16 becomes the largest of its sign. *clamped is raised by as many.
std::vector<float> roundedToHalf(std::vector<float> numbers, size_t* clamped);

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
