#include "validate/light/neural/dense_training.h"

#include <algorithm>
#include <cmath>

#include <torch/utils.h>

#include "runtime_eval/numbers/half.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {

size_t DenseShape::parameterCount() const {
  size_t count = 0;
  for (size_t l = 0; l < layerCount(); ++l) count += static_cast<size_t>(widths[l] + 1) * static_cast<size_t>(widths[l + 1]);
  return count;
}

size_t DenseShape::multiplyAdds() const {
  size_t count = 0;
  for (size_t l = 0; l < layerCount(); ++l) count += static_cast<size_t>(widths[l]) * static_cast<size_t>(widths[l + 1]);
  return count;
}

DenseNetwork::DenseNetwork(DenseShape shape, std::vector<float> parameters)
    : shape_(std::move(shape)), parameters_(std::move(parameters)) {
  NLG_CHECK(shape_.widths.size(), >=, 2u);
  for (const int width : shape_.widths) {
    NLG_CHECK(width, >=, 1);
    NLG_CHECK(width, <=, DenseShape::kMostWidth);
  }
  NLG_CHECK(parameters_.size(), ==, shape_.parameterCount());
}

void DenseNetwork::evaluate(const float* input, float* output) const {
  float from[DenseShape::kMostWidth], to[DenseShape::kMostWidth];
  std::copy_n(input, shape_.widths.front(), from);
  const float* numbers = parameters_.data();
  for (size_t l = 0; l < shape_.layerCount(); ++l) {
    const int inputs = shape_.widths[l], outputs = shape_.widths[l + 1];
    const float* bias = numbers + static_cast<ptrdiff_t>(inputs) * outputs;
    std::copy_n(bias, outputs, to);
    // by inputs, so that the inner loop is over memory that compilers make vectors of
    for (int i = 0; i < inputs; ++i) {
      const float* column = numbers + static_cast<ptrdiff_t>(i) * outputs;
      for (int o = 0; o < outputs; ++o) to[o] += column[o] * from[i];
    }
    numbers = bias + outputs;
    const bool is_last = l + 1 == shape_.layerCount();
    for (int o = 0; o < outputs && !is_last; ++o) to[o] = std::max(0.0f, to[o]);
    std::copy_n(to, outputs, is_last ? output : from);
  }
}

std::vector<float> roundedToHalf(std::vector<float> numbers, size_t* clamped) {
  for (float& number : numbers) {
    Half half;
    if (!halfFromFloat(number, &half)) {
      ++*clamped;
      NLG_CHECK(halfFromFloat(number > 0.0f ? kMaxHalf : -kMaxHalf, &half), ==, true);
    }
    number = floatFromHalf(half);
  }
  return numbers;
}

torch::Tensor initialParameters(const DenseShape& shape, uint64_t seed) {
  torch::Tensor flat = torch::empty({static_cast<int64_t>(shape.parameterCount())});
  float* numbers = flat.data_ptr<float>();
  Random random(seed);
  for (size_t l = 0; l < shape.layerCount(); ++l) {
    const int inputs = shape.widths[l], outputs = shape.widths[l + 1];
    const double deviation = std::sqrt(2.0 / inputs);
    for (int i = 0; i < inputs * outputs; ++i) *numbers++ = static_cast<float>(deviation * random.normal());
    // 0, but drawn: as the starts of published figures were
    for (int o = 0; o < outputs; ++o) *numbers++ = static_cast<float>(random.uniform(0.0, 0.0));
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
    if (l + 1 < shape.layerCount()) input = input.relu();
  }
  return input;
}

std::vector<float> floatsOf(const torch::Tensor& flat) {
  const torch::Tensor numbers = flat.detach().contiguous();
  return {numbers.data_ptr<float>(), numbers.data_ptr<float>() + numbers.numel()};
}

}  // namespace nlg
