// Reads and writes the file of a checkpoint, without libtorch.
//
// A safetensors file of our own reader and writer (docs/reference/formats.md). libtorch's archives are TorchScript: they are read by a
// parser of programs, which a changed archive makes read memory that is not there.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "runtime_eval/weights_file/tensor_file.h"
#include "tool/output_path.h"

namespace nlg {

// What a checkpoint was made with. Resuming with anything else is refused, naming what differs.
struct RunIdentity {
  std::string representation;
  std::string options_json;  // resolved options of the run
  std::string basis_sha256;
  std::string training_set_sha256;  // FunctionSet::sha256

  bool operator==(const RunIdentity&) const = default;
};

// How far a run has come.
struct RunProgress {
  int64_t step = 0;                   // steps done
  int64_t draw = 0;                   // batches drawn: the steps, and what rollbacks left out
  int rollbacks = 0;                  // times that training went back to a good state (loss_guard.h)
  std::vector<double> recent_losses;  // of the last steps
  std::string log_csv;                // one line a validation
};

// The numbers of a run, by name: "network.layer0.weight".
using NamedNumbers = std::map<std::string, std::vector<float>>;

extern const OwnFiles kCheckpointFiles;

// throws   OutputError
void writeCheckpointFile(const std::string& path, const RunIdentity& identity, const RunProgress& progress,
                         const NamedNumbers& numbers);

// A checkpoint in memory, every byte of it verified.
class CheckpointFile {
 public:
  // throws   InputError when the file is missing, damaged (DamageError), or something else
  explicit CheckpointFile(const std::string& path);
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  const std::string& path() const { return path_; }
  // of the bytes that were read, in hexadecimal digits: the file of that name may be another one by now
  std::string sha256() const;
  const RunIdentity& identity() const { return identity_; }
  const RunProgress& progress() const { return progress_; }

  // The numbers of that name, `count` of them and all finite. throws InputError when they are not
  std::vector<float> numbers(const std::string& name, size_t count) const;

 private:
  template <class T>
  std::vector<T> read(const std::string& name) const;
  template <class T>
  std::vector<T> readFinite(const std::string& name) const;
  std::string text(const char* key) const;
  int64_t count(const char* name, uint64_t value) const;

  std::string path_, bytes_;
  TensorFileReader tensors_;
  RunIdentity identity_;
  RunProgress progress_;
};

}  // namespace nlg
