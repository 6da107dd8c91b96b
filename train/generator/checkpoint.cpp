#include "train/generator/checkpoint.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "tool/error.h"

namespace nlg {
namespace {

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

std::string differences(const RunIdentity& found, const RunIdentity& asked) {
  std::string text;
  const auto compare = [&](const std::string& what, const std::string& of_found, const std::string& of_asked) {
    if (of_found != of_asked) text += (text.empty() ? "" : "; ") + what + ": " + of_found + ", asked " + of_asked;
  };
  compare("representation", found.representation, asked.representation);
  const nlohmann::json a = nlohmann::json::parse(found.options_json, nullptr, false),
                       b = nlohmann::json::parse(asked.options_json, nullptr, false);
  if (!a.is_object() || !b.is_object()) {
    compare("options", found.options_json, asked.options_json);
  } else {
    for (const auto& [key, value] : b.items()) compare(key, a.contains(key) ? a[key].dump() : "none", value.dump());
    for (const auto& [key, value] : a.items()) {
      if (!b.contains(key)) compare(key, value.dump(), "none");
    }
  }
  compare("basis", found.basis_sha256, asked.basis_sha256);
  compare("training set", found.training_set_sha256, asked.training_set_sha256);
  return text;
}

void readCheckpoint(const CheckpointFile& file, const RunIdentity& identity, TrainingState* state) {
  const std::string other = differences(file.identity(), identity);
  if (!other.empty()) {
    throw InputError(file.path(), "the run",
                     "a checkpoint of the same run (--restart-on-change starts a new one; another --run keeps both)", other);
  }
  loadNetwork(file, kNetwork, state->network);
  loadNetwork(file, kAverage, state->average);
  if (file.progress().step > 0) loadMoments(file, state);
  static_cast<RunProgress&>(*state) = file.progress();
}

}  // namespace nlg
