// Saves and resumes the state of a training run: written atomically, resumed bit for bit.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "train/generator/network/generator_update.h"
#include "train/generator/run/checkpoint_file.h"

namespace nlg {

struct TrainingState : RunProgress {
  GeneratorNetwork network{nullptr};  // being trained
  GeneratorNetwork average{nullptr};  // its averaged weights: what is validated and exported
  ParameterMoments moments;
};

// throws OutputError
void writeCheckpoint(const std::string& path, const RunIdentity& identity, const TrainingState& state);

// What two runs differ in: "learning_rate: 0.003, asked 0.01; steps: 60, asked 120"; empty where they are the same.
std::string differences(const RunIdentity& found, const RunIdentity& asked);

// Loads into a state whose networks and moments have been made for the same shape. What it throws for leaves the state half loaded.
// throws InputError when the file is of another run, naming what differs, or holds other numbers than such a state has
void readCheckpoint(const CheckpointFile& file, const RunIdentity& identity, TrainingState* state);

// The folder of one training run: checkpoints and their origin (docs/guide/training.md).
//
//   config.json       resolved options
//   provenance.json   revision, options, hashes of data set and basis (tool/provenance.h)
//   log.csv           the training curve so far
//   step-NNNNNNNNN.ckpt   the last two checkpoints
//   latest            link to the newest of them: always to a whole one
class RunFolder {
 public:
  explicit RunFolder(std::string path) : path_(std::move(path)) {}

  // Keeps other trainers away for as long as it lives. throws UsageError where one is at work there
  std::shared_ptr<void> lock() const;

  // The checkpoints that there are, newest first: the first one that is whole is to go on from.
  std::vector<std::string> newestFirst() const;

  // throws OutputError
  void writeOrigin(const nlohmann::ordered_json& config, const nlohmann::ordered_json& provenance) const;

  // Writes the checkpoint of state.step, then what settle() does. Killed at any moment, it leaves a `latest` that is either the
  // checkpoint before or this one.
  // throws OutputError
  void save(const RunIdentity& identity, const TrainingState& state) const;

  // Moves `latest` to a checkpoint that lies here, writes the curve up to it, and removes those before it but the last one. For a run
  // that goes on from it, too: one that was killed just after it wrote the checkpoint left the rest as it was before.
  // checkpoint   its path; state: what it holds
  // throws       OutputError
  void settle(const std::string& checkpoint, const TrainingState& state) const;

  // Removes the checkpoints, the curve and the pictures of another run. throws OutputError
  void clear() const;

 private:
  std::string path_;
};

}  // namespace nlg
