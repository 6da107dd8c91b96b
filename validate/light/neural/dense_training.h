// Trains dense networks in libtorch: their numbers are one flat tensor, in the order of DenseNetwork.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <torch/types.h>

namespace nlg {

// A small dense network for look-ups: plain loops, no library. ReLU behind all layers but the last.

struct DenseShape {
  std::vector<int> widths;  // inputs, hidden layers, outputs: at least two; each in [1, kMostWidth]

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

// Streams of a training's seed: of its networks, and of the sample points that are held out.
inline constexpr uint64_t kNetworkStream = 0x6e6574, kHeldOutStream = 0x68656c64;

// Normal with variance 2 / inputs (He et al., 2015); biases are 0. Takes gradients.
torch::Tensor initialParameters(const DenseShape& shape, uint64_t seed);

// Of one network, or of N of one shape, each with a batch of its own.
//
// parameters   P, or N x P
// input        B x widths.front(), or N x B x widths.front()
// returns      B x widths.back(), or N x B x widths.back()
torch::Tensor evaluateBatch(const DenseShape& shape, const torch::Tensor& parameters, torch::Tensor input);

std::vector<float> floatsOf(const torch::Tensor& flat);

}  // namespace nlg
