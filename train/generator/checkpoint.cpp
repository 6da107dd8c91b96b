#include "train/generator/checkpoint.h"

#include <algorithm>

#include "tool/error.h"

namespace nlg {
namespace {

void requireSame(const CheckpointFile& file, const char* what, const std::string& expected, const std::string& got) {
  if (expected != got) throw InputError(file.path(), what, expected, got);
}

std::vector<float> numbersOf(const torch::Tensor& tensor) {
  const torch::Tensor values = tensor.detach().cpu().contiguous();
  NLG_CHECK(values.element_size(), ==, sizeof(float));
  return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
}

torch::Tensor tensorLike(const torch::Tensor& like, const CheckpointFile& file, const std::string& name) {
  const std::vector<float> values = file.numbers(name, static_cast<size_t>(like.numel()));
  torch::Tensor tensor = torch::empty(like.sizes(), torch::kFloat);
  std::copy(values.begin(), values.end(), tensor.data_ptr<float>());
  return tensor.to(like.device());
}

// Calls each(name, tensor) for all that a network is.
template <class Each>
void forTensors(const std::string& prefix, const GeneratorNetwork& network, const Each& each) {
  for (const auto& parameter : network->named_parameters()) each(prefix + parameter.key(), parameter.value());
  for (const auto& buffer : network->named_buffers()) each(prefix + buffer.key(), buffer.value());
}

void loadNetwork(const CheckpointFile& file, const std::string& prefix, GeneratorNetwork& network) {
  const torch::NoGradGuard no_gradient;
  forTensors(prefix, network,
             [&](const std::string& name, torch::Tensor tensor) { tensor.copy_(tensorLike(tensor, file, name)); });
}

constexpr const char* kNetwork = "network.";
constexpr const char* kAverage = "average.";
constexpr const char* kMeans = "adam.mean.";
constexpr const char* kSquares = "adam.square.";

void loadMoments(const CheckpointFile& file, TrainingState* state) {
  const auto parameters = state->network->named_parameters();
  for (size_t i = 0; i < parameters.size(); ++i) {
    state->moments.mean[i] = tensorLike(state->moments.mean[i], file, kMeans + parameters[i].key());
    state->moments.square[i] = tensorLike(state->moments.square[i], file, kSquares + parameters[i].key());
  }
}

}  // namespace

void writeCheckpoint(const std::string& path, const RunIdentity& identity, const TrainingState& state) {
  NamedNumbers numbers;
  const auto add = [&](const std::string& name, const torch::Tensor& tensor) { numbers[name] = numbersOf(tensor); };
  forTensors(kNetwork, state.network, add);
  forTensors(kAverage, state.average, add);
  if (state.step > 0) {
    const auto parameters = state.network->named_parameters();
    for (size_t i = 0; i < state.moments.mean.size(); ++i) {
      add(kMeans + parameters[i].key(), state.moments.mean[i]);
      add(kSquares + parameters[i].key(), state.moments.square[i]);
    }
  }
  writeCheckpointFile(path, identity, state, numbers);
}

void readCheckpoint(const CheckpointFile& file, const RunIdentity& identity, TrainingState* state) {
  requireSame(file, "representation", identity.representation, file.identity().representation);
  requireSame(file, "options", identity.options_json, file.identity().options_json);
  requireSame(file, "basis", identity.basis_sha256, file.identity().basis_sha256);
  requireSame(file, "training set", identity.training_set_sha256, file.identity().training_set_sha256);
  loadNetwork(file, kNetwork, state->network);
  loadNetwork(file, kAverage, state->average);
  if (file.progress().step > 0) loadMoments(file, state);
  static_cast<RunProgress&>(*state) = file.progress();
}

}  // namespace nlg
