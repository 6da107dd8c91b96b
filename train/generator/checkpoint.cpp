#include "train/generator/checkpoint.h"

#include <torch/serialize.h>
#include <torch/version.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <sstream>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kKind = "nlg-checkpoint-3";
constexpr size_t kDigestSize = 64;

void writeText(torch::serialize::OutputArchive& archive, const std::string& key, const std::string& text) {
  archive.write(key, c10::IValue(text));
}

std::string readText(torch::serialize::InputArchive& archive, const std::string& key) {
  c10::IValue value;
  archive.read(key, value);
  return value.toStringRef();
}

// libtorch reports what is wrong with an archive by several kinds of exceptions: all of them become one line.
template <class Read>
void readArchive(const std::string& path, const Read& read) {
  try {
    torch::serialize::InputArchive archive;
    // libtorch reads archives without looking at their checksums: ours stands before the archive
    const std::string file = readFile(path);
    const std::string digest = file.substr(0, kDigestSize), bytes = file.substr(digest.size());
    // one of its bits may be damaged; most of them are what stands at the beginning of another kind of file
    const auto digits =
        std::count_if(digest.begin(), digest.end(), [](unsigned char digit) { return std::isxdigit(digit) != 0; });
    if (digest.size() == kDigestSize && digits < std::ssize(digest) / 2)
      throw InputError(path, "first line", "the SHA-256 of a checkpoint", "other bytes");
    if (digest != sha256(bytes)) throw DamageError(path, "SHA-256 of the archive", "that of the file's first line", "another");
    archive.load_from(bytes.data(), bytes.size());
    if (readText(archive, "kind") != kKind) throw InputError(path, "kind", kKind, "another kind of archive");
    read(archive);
  } catch (const ToolError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;  // says nothing of the file
  } catch (const std::exception& error) {
    const std::string text = error.what();
    throw InputError(path, "archive", "a whole checkpoint", text.substr(0, text.find('\n')));
  }
}

RunIdentity identityOf(torch::serialize::InputArchive& archive) {
  return {readText(archive, "representation"), readText(archive, "options"), readText(archive, "basis_sha256"),
          readText(archive, "training_set_sha256")};
}

void requireSame(const std::string& path, const char* what, const std::string& expected, const std::string& got) {
  if (expected != got) throw InputError(path, what, expected, got);
}

// Adam's moments in the order of the parameters: libtorch's own format names them by their addresses in memory.
#if TORCH_VERSION_MAJOR >= 2
void* addressOf(const torch::Tensor& parameter) { return parameter.unsafeGetTensorImpl(); }
#else
std::string addressOf(const torch::Tensor& parameter) { return c10::guts::to_string(parameter.unsafeGetTensorImpl()); }
#endif

void writeMoments(const TrainingState& state, torch::serialize::OutputArchive& archive) {
  const std::vector<torch::optim::AdamParamState*> all = adamMoments(state);
  for (size_t i = 0; i < all.size(); ++i) {
    archive.write("step" + std::to_string(i), c10::IValue(all[i]->step()));
    archive.write("mean" + std::to_string(i), all[i]->exp_avg());
    archive.write("square" + std::to_string(i), all[i]->exp_avg_sq());
  }
}

// What has to be the same in a run and in its checkpoint. libtorch's own loading of a module gives a tensor whatever shape the
// archive has, and takes numbers of another type for its own.
struct TensorForm {
  std::vector<int64_t> sizes;
  torch::ScalarType type;
  bool operator==(const TensorForm&) const = default;
};

TensorForm formOf(const torch::Tensor& tensor) { return {tensor.sizes().vec(), tensor.scalar_type()}; }

std::string nameOf(const TensorForm& form) {
  std::string shape;
  for (const int64_t size : form.sizes) shape += (shape.empty() ? "" : " x ") + std::to_string(size);
  return (shape.empty() ? "one" : shape) + std::string(" of ") + c10::toString(form.type);
}

enum class TensorRole { parameter, buffer };

// The archive's tensor of that name, once it is known to have the form of this one.
torch::Tensor readLike(const std::string& path, const std::string& place, torch::serialize::InputArchive& archive,
                       const std::string& key, const torch::Tensor& like, TensorRole role = TensorRole::parameter) {
  torch::Tensor tensor;
  archive.read(key, tensor, role == TensorRole::buffer);
  const TensorForm expected = formOf(like), form = formOf(tensor);
  if (!(form == expected)) throw InputError(path, place + " " + key, nameOf(expected), nameOf(form));
  return tensor.contiguous();
}

// The archive of a module, as torch::nn::Module::save makes it.
void loadModule(const std::string& path, const std::string& place, torch::serialize::InputArchive& archive,
                torch::nn::Module& module) {
  torch::NoGradGuard guard;
  for (const auto& tensor : module.named_parameters(false))
    tensor.value().copy_(readLike(path, place, archive, tensor.key(), tensor.value()));
  for (const auto& tensor : module.named_buffers(false))
    tensor.value().copy_(readLike(path, place, archive, tensor.key(), tensor.value(), TensorRole::buffer));
  for (const auto& child : module.named_children()) {
    torch::serialize::InputArchive inner;
    archive.read(child.key(), inner);
    loadModule(path, place + " " + child.key(), inner, *child.value());
  }
}

void readMoments(const std::string& path, torch::serialize::InputArchive& archive, TrainingState* state) {
  const std::vector<torch::Tensor> parameters = state->network->parameters();
  for (size_t i = 0; i < parameters.size(); ++i) {
    c10::IValue step;
    if (!archive.try_read("step" + std::to_string(i), step)) continue;
    auto moments = std::make_unique<torch::optim::AdamParamState>();
    const torch::Tensor mean = readLike(path, "optimizer", archive, "mean" + std::to_string(i), parameters[i]);
    const torch::Tensor square = readLike(path, "optimizer", archive, "square" + std::to_string(i), parameters[i]);
    moments->step(step.toInt());
    moments->exp_avg(mean.to(parameters[i].device()));
    moments->exp_avg_sq(square.to(parameters[i].device()));
    state->optimizer->state()[addressOf(parameters[i])] = std::move(moments);
  }
}

torch::Tensor tensorOf(const std::vector<double>& values) {
  torch::Tensor tensor = torch::empty({static_cast<int64_t>(values.size())}, torch::kDouble);
  std::copy(values.begin(), values.end(), tensor.data_ptr<double>());
  return tensor;
}

int64_t readNumber(torch::serialize::InputArchive& archive, const std::string& key) {
  c10::IValue value;
  archive.read(key, value);
  return value.toInt();
}

int64_t readCount(const std::string& path, torch::serialize::InputArchive& archive, const std::string& key) {
  const int64_t count = readNumber(archive, key);
  if (count < 0 || count > std::numeric_limits<int>::max())
    throw InputError(path, key, "a number from 0 to 2147483647", std::to_string(count));
  return count;
}

}  // namespace

std::vector<torch::optim::AdamParamState*> adamMoments(const TrainingState& state) {
  std::vector<torch::optim::AdamParamState*> moments;
  for (const torch::Tensor& parameter : state.network->parameters()) {
    const auto found = state.optimizer->state().find(addressOf(parameter));
    if (found == state.optimizer->state().end()) return {};  // before the first step
    moments.push_back(static_cast<torch::optim::AdamParamState*>(found->second.get()));
  }
  return moments;
}

void writeCheckpoint(const std::string& path, const RunIdentity& identity, const TrainingState& state) {
  writeAtomically(path, [&](const std::string& temporary_path) {
    torch::serialize::OutputArchive archive, network, average, optimizer;
    writeText(archive, "kind", kKind);
    writeText(archive, "representation", identity.representation);
    writeText(archive, "options", identity.options_json);
    writeText(archive, "basis_sha256", identity.basis_sha256);
    writeText(archive, "training_set_sha256", identity.training_set_sha256);
    writeText(archive, "log", state.log_csv);
    archive.write("step", c10::IValue(state.step));
    archive.write("draw", c10::IValue(state.draw));
    archive.write("rollbacks", c10::IValue(static_cast<int64_t>(state.rollbacks)));
    archive.write("recent_losses", tensorOf(state.recent_losses));
    state.network->save(network);
    state.average->save(average);
    writeMoments(state, optimizer);
    archive.write("network", network);
    archive.write("average", average);
    archive.write("optimizer", optimizer);
    // through a stream: an archive written to a file carries that file's name, and with it our process id
    std::ostringstream bytes;
    archive.save_to(bytes);
    std::ofstream stream(temporary_path, std::ios::binary);
    stream << sha256(bytes.str()) << bytes.str();
    if (!stream.flush()) throw OutputError(path, std::strerror(errno));
  });
}

void readCheckpoint(const std::string& path, const RunIdentity& identity, TrainingState* state) {
  readArchive(path, [&](torch::serialize::InputArchive& archive) {
    const RunIdentity found = identityOf(archive);
    requireSame(path, "representation", identity.representation, found.representation);
    requireSame(path, "options", identity.options_json, found.options_json);
    requireSame(path, "basis", identity.basis_sha256, found.basis_sha256);
    requireSame(path, "training set", identity.training_set_sha256, found.training_set_sha256);
    torch::serialize::InputArchive network, average, optimizer;
    archive.read("network", network);
    archive.read("average", average);
    archive.read("optimizer", optimizer);
    loadModule(path, "network", network, *state->network);
    loadModule(path, "average", average, *state->average);
    readMoments(path, optimizer, state);
    state->step = readCount(path, archive, "step");
    state->draw = readCount(path, archive, "draw");
    state->rollbacks = static_cast<int>(readCount(path, archive, "rollbacks"));
    torch::Tensor losses;
    archive.read("recent_losses", losses);
    losses = losses.contiguous();
    state->recent_losses.assign(losses.data_ptr<double>(), losses.data_ptr<double>() + losses.numel());
    state->log_csv = readText(archive, "log");
  });
}

CheckpointHead readCheckpointHead(const std::string& path) {
  CheckpointHead head;
  readArchive(path, [&](torch::serialize::InputArchive& archive) {
    head = {identityOf(archive), readNumber(archive, "step"), readNumber(archive, "rollbacks")};
  });
  return head;
}

RunIdentity readIdentity(const std::string& path) { return readCheckpointHead(path).identity; }

}  // namespace nlg
