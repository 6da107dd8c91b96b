#include "train/generator/run/checkpoint.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include <sys/file.h>
#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <unistd.h>

#include "tool/atomic_file.h"
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

namespace fs = std::filesystem;

constexpr size_t kKeptCheckpoints = 2;

std::string nameOf(int64_t step) {
  // so many digits that names sort as steps do
  char name[32];
  std::snprintf(name, sizeof name, "step-%09lld.ckpt", static_cast<long long>(step));
  return name;
}

// Files of a folder that are named by steps, oldest first.
std::vector<fs::path> filesOfSteps(const std::string& folder, std::string_view begins, std::string_view ends) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(begins) && name.ends_with(ends)) found.push_back(entry->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<fs::path> checkpoints(const std::string& folder) { return filesOfSteps(folder, "step-", ".ckpt"); }

void removeFile(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw OutputError(path.string(), error.message());
}

// A link cannot be overwritten, but renamed over.
void pointTo(const fs::path& link, const std::string& target) {
  const fs::path fresh = link.string() + ".tmp";
  ::unlink(fresh.c_str());
  if (::symlink(target.c_str(), fresh.c_str()) != 0 || ::rename(fresh.c_str(), link.c_str()) != 0) {
    throw OutputError(link.string(), std::generic_category().message(errno));
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

std::shared_ptr<void> RunFolder::lock() const {
  std::error_code error;
  fs::create_directories(path_, error);
  const std::string path = (fs::path(path_) / ".lock").string();
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file < 0) throw OutputError(path, std::generic_category().message(errno));
  // held by the open file: gone with the process, however it ends
  std::shared_ptr<void> held(nullptr, [file](void*) { ::close(file); });
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) throw UsageError("--run", "a folder that no other nlg-train uses", path_);
  return held;
}

std::vector<std::string> RunFolder::newestFirst() const {
  std::vector<std::string> paths;
  for (const fs::path& path : checkpoints(path_)) paths.insert(paths.begin(), path.string());
  return paths;
}

void RunFolder::writeOrigin(const nlohmann::ordered_json& config, const nlohmann::ordered_json& provenance) const {
  writeFileAtomically((fs::path(path_) / "config.json").string(), config.dump(2) + '\n');
  writeFileAtomically((fs::path(path_) / "provenance.json").string(), provenance.dump(2) + '\n');
}

void RunFolder::save(const RunIdentity& identity, const TrainingState& state) const {
  const std::string path = (fs::path(path_) / nameOf(state.step)).string();
  writeCheckpoint(path, identity, state);
  settle(path, state);
}

void RunFolder::settle(const std::string& checkpoint, const TrainingState& state) const {
  pointTo(fs::path(path_) / "latest", fs::path(checkpoint).filename().string());
  writeFileAtomically((fs::path(path_) / "log.csv").string(), state.log_csv);
  std::vector<fs::path> kept = checkpoints(path_);
  // later ones are damaged, or this would not be the newest: training writes them anew
  std::erase_if(kept, [&](const fs::path& path) { return path.filename() > fs::path(checkpoint).filename(); });
  for (size_t i = 0; i + kKeptCheckpoints < kept.size(); ++i) removeFile(kept[i]);
}

void RunFolder::clear() const {
  for (const char* name : {"latest", "log.csv"}) removeFile(fs::path(path_) / name);
  for (const fs::path& path : checkpoints(path_)) removeFile(path);
  // pictures of its worst functions, or what they are to be drawn of
  for (const char* ending : {".png", ".json"}) {
    for (const fs::path& path : filesOfSteps(path_, "worst-", ending)) removeFile(path);
  }
}

}  // namespace nlg
