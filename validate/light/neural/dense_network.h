// A small dense network for look-ups: plain loops, no library.
#pragma once

#include <cstddef>
#include <vector>

namespace nlg {

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

}  // namespace nlg
