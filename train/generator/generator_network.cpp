#include "train/generator/generator_network.h"

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// He-normal weights from our own generator: the same start with every version of libtorch.
void initialise(torch::nn::Linear& layer, double deviation, uint64_t seed) {
  torch::NoGradGuard guard;
  Random random(seed);
  float* weights = layer->weight.data_ptr<float>();
  for (int64_t i = 0; i < layer->weight.numel(); ++i) weights[i] = static_cast<float>(deviation * random.normal());
  layer->bias.zero_();
}

std::vector<float> toVector(const torch::Tensor& tensor) {
  const torch::Tensor flat = tensor.detach().contiguous();
  return {flat.data_ptr<float>(), flat.data_ptr<float>() + flat.numel()};
}

}  // namespace

GeneratorNetworkImpl::GeneratorNetworkImpl(const GeneratorShape& shape, const Theta& theta0, uint64_t seed) : shape_(shape) {
  const int theta_count = static_cast<int>(theta0.size());
  int input_count = shape.coefficient_count;
  for (int l = 0; l < shape.layer_count; ++l) {
    const bool last = l + 1 == shape.layer_count;
    const int output_count = last ? theta_count : shape.width;
    torch::nn::Linear layer(input_count, output_count);
    // layers beside a skip start small, so that the sum of all of them stays near the scale of the input
    const double gain = last ? 0.0 : input_count == output_count ? 0.5 : 1.0;
    initialise(layer, gain * std::sqrt(2.0 / input_count), mixSeed(seed, 3, l));
    layers_.push_back(register_module("layer" + std::to_string(l), layer));
    input_count = output_count;
  }
  torch::Tensor start = torch::empty({static_cast<int64_t>(theta0.size())});
  std::copy(theta0.begin(), theta0.end(), start.data_ptr<float>());
  theta0_ = register_buffer("theta0", start);
}

torch::Tensor GeneratorNetworkImpl::forward(torch::Tensor coefficients) {
  torch::Tensor values = std::move(coefficients);
  for (size_t l = 0; l + 1 < layers_.size(); ++l) {
    const torch::Tensor hidden = torch::leaky_relu(layers_[l]->forward(values), shape_.slope);
    values = hidden.size(1) == values.size(1) ? hidden + values : hidden;
  }
  return theta0_ + shape_.output_scale * layers_.back()->forward(values);
}

GeneratorData GeneratorNetworkImpl::toData(const Representation& representation, const BasisData& basis) const {
  GeneratorData data;
  data.representation = representation;
  data.slope = static_cast<float>(shape_.slope);
  data.basis = basis;
  for (const torch::nn::Linear& layer : layers_) {
    data.layers.push_back({static_cast<int>(layer->weight.size(1)), static_cast<int>(layer->weight.size(0)),
                           toVector(layer->weight), toVector(layer->bias)});
  }
  data.exact_last_layer = solvesLastLayer(representation);
  data.theta0 = toVector(theta0_);
  data.output_scale.assign(data.theta0.size(), static_cast<float>(shape_.output_scale));
  return data;
}

}  // namespace nlg
