#include "train/generator/run/checkpoint_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/weights_file/safetensors_layout.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

constexpr const char* kKind = "nlg-checkpoint-1";
constexpr const char* kExpected = "a checkpoint of nlg-train";
constexpr size_t kCounts = 3;  // step, draw, rollbacks

}  // namespace

const OwnFiles kCheckpointFiles = {kExpected, [](std::string_view bytes) { return hold(bytes, kKind); }};

void writeCheckpointFile(const std::string& path, const RunIdentity& identity, const RunProgress& progress,
                         const NamedNumbers& numbers) {
  const std::vector<uint64_t> counts = {static_cast<uint64_t>(progress.step), static_cast<uint64_t>(progress.draw),
                                        static_cast<uint64_t>(progress.rollbacks)};
  const std::vector<uint8_t> log(progress.log_csv.begin(), progress.log_csv.end());
  TensorFileWriter writer;
  writer.add("counts", counts);
  writer.add("recent_losses", progress.recent_losses);
  writer.add("log", log);
  for (const auto& [name, values] : numbers) writer.add(name, values);
  std::string bytes;
  const FileResult result = writer.serialize({{"kind", kKind},
                                              {"representation", identity.representation},
                                              {"options", identity.options_json},
                                              {"basis_sha256", identity.basis_sha256},
                                              {"training_set_sha256", identity.training_set_sha256}},
                                             &bytes);
  if (!result.ok()) throw OutputError(path, result.detail);
  writeFileAtomically(path, bytes);
}

CheckpointFile::CheckpointFile(const std::string& path) : path_(path), bytes_(readFile(path)) {
  const FileResult opened = tensors_.openBytes(bytes_);
  // of a file that is read but names no digest requireRead would only say so: no checkpoint is without one
  if (!opened.ok()) requireRead(path, opened, kExpected);
  const std::string kind = text("kind");
  if (kind != kKind) throw InputError(path, "kind", kKind, "'" + kind + "'");
  if (!tensors_.hasDigest()) throw DamageError(path, kDigestKey, kExpected, kDigestMissing);
  identity_ = {text("representation"), text("options"), text("basis_sha256"), text("training_set_sha256")};
  const auto counts = read<uint64_t>("counts");
  if (counts.size() != kCounts)
    throw InputError(path, "counts", std::to_string(kCounts) + " numbers", std::to_string(counts.size()));
  progress_.step = count("step", counts[0]);
  progress_.draw = count("draw", counts[1]);
  progress_.rollbacks = static_cast<int>(count("rollbacks", counts[2]));
  progress_.recent_losses = readFinite<double>("recent_losses");
  const auto log = read<uint8_t>("log");
  progress_.log_csv.assign(log.begin(), log.end());
}

std::string CheckpointFile::sha256() const { return nlg::sha256(bytes_); }

template <class T>
std::vector<T> CheckpointFile::read(const std::string& name) const {
  std::vector<T> values;
  requireRead(path_, tensors_.read(name, &values), kExpected);
  return values;
}

std::string CheckpointFile::text(const char* key) const {
  const auto found = tensors_.metadata().find(key);
  if (found == tensors_.metadata().end()) throw InputError(path_, key, kExpected, "a file without it");
  return found->second;
}

int64_t CheckpointFile::count(const char* name, uint64_t value) const {
  constexpr auto kMost = static_cast<uint64_t>(std::numeric_limits<int>::max());
  if (value > kMost) throw InputError(path_, name, "a number from 0 to " + std::to_string(kMost), std::to_string(value));
  return static_cast<int64_t>(value);
}

template <class T>
std::vector<T> CheckpointFile::readFinite(const std::string& name) const {
  std::vector<T> values = read<T>(name);
  const auto wrong = std::find_if(values.begin(), values.end(), [](T value) { return !std::isfinite(value); });
  if (wrong == values.end()) return values;
  throw InputError(path_, name + ", number " + std::to_string(wrong - values.begin()), "a finite one", std::to_string(*wrong));
}

std::vector<float> CheckpointFile::numbers(const std::string& name, size_t count) const {
  std::vector<float> values = readFinite<float>(name);
  if (values.size() != count) {
    throw InputError(path_, name, std::to_string(count) + " numbers, as the run's options make them",
                     std::to_string(values.size()));
  }
  return values;
}

}  // namespace nlg
