#include "validate/light/neural/dense_training.h"

#include <cmath>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {

torch::Tensor initialParameters(const DenseShape& shape, uint64_t seed) {
  torch::Tensor flat = torch::empty({static_cast<int64_t>(shape.parameterCount())});
  float* numbers = flat.data_ptr<float>();
  Random random(seed);
  for (size_t l = 0; l < shape.layerCount(); ++l) {
    const int inputs = shape.widths[l], outputs = shape.widths[l + 1];
    const bool is_sine = shape.activation == Activation::sine;
    const double within = l == 0 ? 1.0 / inputs : std::sqrt(6.0 / inputs), deviation = std::sqrt(2.0 / inputs);
    for (int i = 0; i < inputs * outputs; ++i)
      *numbers++ = static_cast<float>(is_sine ? random.uniform(-within, within) : deviation * random.normal());
    const double bias = is_sine ? 1.0 / std::sqrt(inputs) : 0.0;
    for (int o = 0; o < outputs; ++o) *numbers++ = static_cast<float>(random.uniform(-bias, bias));
  }
  return flat.requires_grad_();
}

torch::Tensor evaluateBatch(const DenseShape& shape, const torch::Tensor& parameters, torch::Tensor input) {
  NLG_CHECK(input.size(-1), ==, shape.widths.front());
  int64_t at = 0;
  for (size_t l = 0; l < shape.layerCount(); ++l) {
    const int64_t inputs = shape.widths[l], outputs = shape.widths[l + 1];
    const torch::Tensor matrix = parameters.narrow(-1, at, inputs * outputs).unflatten(-1, {inputs, outputs});
    const torch::Tensor bias = parameters.narrow(-1, at + inputs * outputs, outputs);
    at += (inputs + 1) * outputs;
    input = input.dim() == 2 ? torch::addmm(bias, input, matrix) : torch::baddbmm(bias.unsqueeze(1), input, matrix);
    if (l + 1 == shape.layerCount()) break;
    if (shape.activation == Activation::relu) {
      input = input.relu();
    } else {
      input = l == 0 ? (shape.first_frequency * input).sin() : input.sin();
    }
  }
  return input;
}

std::vector<float> floatsOf(const torch::Tensor& flat) {
  const torch::Tensor numbers = flat.detach().contiguous();
  return {numbers.data_ptr<float>(), numbers.data_ptr<float>() + numbers.numel()};
}

}  // namespace nlg
