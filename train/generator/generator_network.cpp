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

std::vector<GeneratorLayer> toLayers(const std::vector<torch::nn::Linear>& layers) {
  std::vector<GeneratorLayer> result;
  for (const torch::nn::Linear& layer : layers) {
    result.push_back({static_cast<int>(layer->weight.size(1)), static_cast<int>(layer->weight.size(0)), toVector(layer->weight),
                      toVector(layer->bias)});
  }
  return result;
}

// Hidden layers with LeakyReLU and skips, then a linear one.
torch::Tensor runLayers(std::vector<torch::nn::Linear>& layers, double slope, torch::Tensor values) {
  for (size_t l = 0; l + 1 < layers.size(); ++l) {
    const torch::Tensor hidden = torch::leaky_relu(layers[l]->forward(values), slope);
    values = hidden.size(1) == values.size(1) ? hidden + values : hidden;
  }
  return layers.back()->forward(values);
}

}  // namespace

GeneratorNetworkImpl::GeneratorNetworkImpl(const GeneratorShape& shape, const Theta& theta0, uint64_t seed) : shape_(shape) {
  const int theta_count = static_cast<int>(theta0.size());
  const auto addLayers = [&](const std::string& name, int input_count, int width, int layer_count, uint64_t stream) {
    std::vector<torch::nn::Linear> layers;
    for (int l = 0; l < layer_count; ++l) {
      const bool last = l + 1 == layer_count;
      const int output_count = last ? theta_count : width;
      torch::nn::Linear layer(input_count, output_count);
      // layers beside a skip start small, so that the sum of all of them stays near the scale of the input
      const double gain = last ? 0.0 : input_count == output_count ? 0.5 : 1.0;
      initialise(layer, gain * std::sqrt(2.0 / input_count), mixSeed(seed, stream, l));
      layers.push_back(register_module(name + std::to_string(l), layer));
      input_count = output_count;
    }
    return layers;
  };
  layers_ = addLayers("layer", shape.coefficient_count, shape.width, shape.layer_count, 3);
  if (shape.correction_steps > 0) {
    const CorrectionFeatures features{shape.coefficient_count, theta_count};
    correction_layers_ = addLayers("correction", features.count(), shape.correction_width, shape.correction_layers, 4);
  }
  torch::Tensor start = torch::empty({static_cast<int64_t>(theta0.size())});
  std::copy(theta0.begin(), theta0.end(), start.data_ptr<float>());
  theta0_ = register_buffer("theta0", start);
}

torch::Tensor GeneratorNetworkImpl::forward(torch::Tensor coefficients) {
  return theta0_ + shape_.output_scale * runLayers(layers_, shape_.slope, std::move(coefficients));
}

torch::Tensor GeneratorNetworkImpl::correctionFeatures(const torch::Tensor& coefficients, const torch::Tensor& theta,
                                                       const torch::Tensor& mean_square, const torch::Tensor& gradient) const {
  const torch::Tensor norm = gradient.norm(2, 1, true) + 1e-12;
  return torch::cat(
      {coefficients, ((theta - theta0_) / shape_.theta_unit).asinh(),
       gradient / norm * std::sqrt(static_cast<double>(theta.size(1))), norm.log10(), (mean_square.unsqueeze(1) + 1e-8).log10()},
      1);
}

torch::Tensor GeneratorNetworkImpl::correction(torch::Tensor features) {
  return shape_.output_scale * runLayers(correction_layers_, shape_.slope, std::move(features));
}

GeneratorData GeneratorNetworkImpl::toData(const Representation& representation, const BasisData& basis) const {
  GeneratorData data;
  data.representation = representation;
  data.slope = static_cast<float>(shape_.slope);
  data.basis = basis;
  data.layers = toLayers(layers_);
  data.correction.step_count = shape_.correction_steps;
  data.correction.theta_unit = static_cast<float>(shape_.theta_unit);
  data.correction.exact_last_layer = solvesLastLayer(representation);
  data.correction.layers = toLayers(correction_layers_);
  data.theta0 = toVector(theta0_);
  data.output_scale.assign(data.theta0.size(), static_cast<float>(shape_.output_scale));
  return data;
}

}  // namespace nlg
