#include "train/generator/network/generator_network.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Normal numbers from our own generator: the same start with every version of libtorch.
void initialise(torch::Tensor& matrix, double deviation, uint64_t seed) {
  torch::NoGradGuard guard;
  Random random(seed);
  float* numbers = matrix.data_ptr<float>();
  for (int64_t i = 0; i < matrix.numel(); ++i) numbers[i] = static_cast<float>(deviation * random.normal());
}

// Of components of samples at the start, times √384: what they yield then is about as large as standardised coefficients.
constexpr double kComponentGain = 3.0;

std::vector<float> toVector(const torch::Tensor& tensor) {
  const torch::Tensor flat = tensor.detach().contiguous();
  return {flat.data_ptr<float>(), flat.data_ptr<float>() + flat.numel()};
}

// The codes of an untrained dictionary, whose unit is not a step yet.
constexpr float kStartDeviation = 10.0f;
// Of the generator's learning rate: a dictionary that moves as fast spoils what the generator has learned of it.
constexpr double kDictionaryRate = 0.2;
// What logits are where nothing is known of a function: most points are seen.
constexpr float kStartLogit = 1.5f;

// Random waves, from long to short.
torch::Tensor startDictionary(const GeneratorShape& shape, uint64_t seed) {
  const int r = shape.dictionary_resolution, K = shape.code_count;
  torch::Tensor start = torch::empty({int64_t{r} * r * r, K + 1});
  float* nodes = start.data_ptr<float>();
  for (int k = 0; k < K; ++k) {
    Random random(mixSeed(seed, 5, k));
    const double frequency = 0.5 + 4.5 * k / std::max(1, K - 1);
    const double wave[3] = {frequency * random.normal(), frequency * random.normal(), frequency * random.normal()};
    const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
    for (int n = 0; n < r * r * r; ++n) {
      const int along[3] = {n % r, n / r % r, n / (r * r)};
      double angle = phase;
      for (int axis = 0; axis < 3; ++axis) angle += wave[axis] * (2.0 * along[axis] / (r - 1) - 1.0);
      nodes[n * (K + 1) + k] = static_cast<float>(2.0 / std::sqrt(K) * std::cos(angle));
    }
  }
  for (int n = 0; n < r * r * r; ++n) nodes[n * (K + 1) + K] = kStartLogit;
  return start;
}

// Bytes times the power of two by which the largest number of each row fits. Numbers that were rounded before stay, bit for bit.
// nodes   r³ x (K + 1)
DictionaryData roundedDictionary(const GeneratorShape& shape, const std::vector<float>& nodes,
                                 const std::vector<float>& deviations) {
  const int r = shape.dictionary_resolution, K = shape.code_count, node_count = r * r * r;
  DictionaryData data{r, K, {}, {}, deviations};
  for (int k = 0; k <= K; ++k) {
    float largest = 1e-4f;
    for (int n = 0; n < node_count; ++n) largest = std::max(largest, std::fabs(nodes[n * (K + 1) + k]));
    const int exponent = static_cast<int>(std::ceil(std::log2(largest / 127.0f)));
    data.exponents.push_back(static_cast<int8_t>(exponent));
    for (int n = 0; n < node_count; ++n)
      data.nodes.push_back(static_cast<int8_t>(std::nearbyint(std::ldexp(nodes[n * (K + 1) + k], -exponent))));
  }
  return data;
}

torch::Tensor toTensor(const std::vector<float>& values, at::IntArrayRef sizes) { return torch::tensor(values).view(sizes); }

}  // namespace

GeneratorShape shapeOf(const GeneratorData& data, GeneratorShape shape) {
  shape.input = data.basis.input;
  shape.coefficient_count = data.basis.coefficientCount();
  shape.layer_count = static_cast<int>(data.layers.size());
  shape.width = data.layers.back().input_count;
  shape.slope = data.slope;
  shape.exact_last_layer = data.exact_last_layer;
  shape.code_count = data.representation.isCode() ? data.representation.code_count : 0;
  if (shape.code_count > 0) shape.dictionary_resolution = data.representation.dictionary->resolution();
  return shape;
}

GeneratorNetworkImpl::GeneratorNetworkImpl(const GeneratorShape& shape, const Theta& theta0, uint64_t seed) : shape_(shape) {
  const int theta_count = static_cast<int>(theta0.size());
  int input_count = shape.coefficient_count;
  if (shape.input == GeneratorInput::samples) {
    const int length = inputCount(shape.input);
    components_ =
        register_parameter("components", torch::empty({kParityClassCount, shape.coefficient_count / kParityClassCount, length}));
    initialise(components_, kComponentGain / std::sqrt(length), mixSeed(seed, 6));
  }
  for (int l = 0; l < shape.layer_count; ++l) {
    const bool last = l + 1 == shape.layer_count;
    const int output_count = last ? theta_count : shape.width;
    torch::nn::Linear layer(input_count, output_count);
    // layers beside a skip start small, so that the sum of all of them stays near the scale of the input
    const double gain = last ? 0.0 : input_count == output_count ? 0.5 : 1.0;
    initialise(layer->weight, gain * std::sqrt(2.0 / input_count), mixSeed(seed, 3, l));
    {
      const torch::NoGradGuard guard;
      layer->bias.zero_();
    }
    layers_.push_back(register_module("layer" + std::to_string(l), layer));
    input_count = output_count;
  }
  torch::Tensor start = torch::empty({static_cast<int64_t>(theta0.size())});
  std::copy(theta0.begin(), theta0.end(), start.data_ptr<float>());
  theta0_ = register_buffer("theta0", start);
  if (shape.code_count == 0) return;
  dictionary_ = register_parameter("dictionary", startDictionary(shape, seed));
  deviations_ = register_buffer("deviations", torch::full({shape.code_count}, kStartDeviation));
  // which parameter the dictionary is: it learns at a rate of its own
  const auto all = named_parameters();
  while (all[dictionary_parameter_].key() != "dictionary") ++dictionary_parameter_;
}

torch::Tensor GeneratorNetworkImpl::dictionaryAt(const PointSet& points, int first, int count) {
  const int r = shape_.dictionary_resolution;
  // eight nodes and their shares for each point: one product that libtorch can differentiate
  torch::Tensor nodes = torch::empty({int64_t{count} * 8}, torch::kLong), shares = torch::empty({int64_t{count} * 8, 1});
  int64_t* node = nodes.data_ptr<int64_t>();
  float* share = shares.data_ptr<float>();
  for (int i = first; i < first + count; ++i) {
    const auto [low, part] = placeAmongNodes(r, {points.x[i], points.y[i], points.z[i]});
    for (int corner = 0; corner < 8; ++corner) {
      int64_t index = 0;
      float weight = 1.0f;
      for (int axis = 2; axis >= 0; --axis) {
        const int high = corner >> axis & 1;
        index = index * r + low[axis] + high;
        weight *= high ? part[axis] : 1.0f - part[axis];
      }
      *node++ = index;
      *share++ = weight;
    }
  }
  return (dictionary_.cpu().index_select(0, nodes) * shares).view({count, 8, dictionary_.size(1)}).sum(1);
}

double GeneratorNetworkImpl::rateFactor(size_t parameter) const {
  return shape_.code_count > 0 && parameter == dictionary_parameter_ ? kDictionaryRate : 1.0;
}

torch::Tensor GeneratorNetworkImpl::forward(torch::Tensor input) {
  torch::Tensor values = std::move(input);
  if (components_.defined()) {
    // a product for each parity class
    const torch::Tensor classes = values.view({-1, kParityClassCount, inputCount(shape_.input)}).transpose(0, 1);
    values = torch::bmm(classes, components_.transpose(1, 2)).transpose(0, 1).reshape({-1, shape_.coefficient_count});
  }
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
  if (components_.defined()) data.basis.components = toVector(components_);
  for (const torch::nn::Linear& layer : layers_) {
    data.layers.push_back({static_cast<int>(layer->weight.size(1)), static_cast<int>(layer->weight.size(0)),
                           toVector(layer->weight), toVector(layer->bias)});
  }
  data.exact_last_layer = solvesLastLayer(representation);
  if (representation.isCode()) {
    data.representation = Representation::code(
        std::make_shared<Dictionary>(roundedDictionary(shape_, toVector(dictionary_), toVector(deviations_))));
  }
  data.theta0 = toVector(theta0_);
  data.output_scale.assign(data.theta0.size(), static_cast<float>(shape_.output_scale));
  return data;
}

void GeneratorNetworkImpl::takeNumbers(const GeneratorData& data) {
  const torch::NoGradGuard guard;
  if (components_.defined()) components_.copy_(toTensor(data.basis.components, components_.sizes()));
  for (size_t l = 0; l < layers_.size(); ++l) {
    const GeneratorLayer& layer = data.layers[l];
    torch::Tensor weight = toTensor(layer.weight, {layer.output_count, layer.input_count}), bias = toTensor(layer.bias, {-1});
    // a file has an output scale for every number, which goes into the last layer
    if (l + 1 == layers_.size()) {
      const torch::Tensor scale = toTensor(data.output_scale, {-1}) / shape_.output_scale;
      weight = weight * scale.view({-1, 1}), bias = bias * scale;
    }
    layers_[l]->weight.copy_(weight);
    layers_[l]->bias.copy_(bias);
  }
  theta0_.copy_(toTensor(data.theta0, {-1}));
  if (shape_.code_count == 0) return;
  const Dictionary& dictionary = *data.representation.dictionary;
  for (int k = 0; k <= shape_.code_count; ++k) {
    const float* row = dictionary.row(k);
    dictionary_.select(1, k).copy_(toTensor({row, row + dictionary.nodeCount()}, {-1}));
  }
  deviations_.copy_(toTensor(dictionary.data().deviations, {-1}));
}

}  // namespace nlg
