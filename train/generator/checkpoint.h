// A training run's state on disk: written atomically, resumed bit for bit.
#pragma once

#include <torch/optim/adam.h>

#include <string>
#include <vector>

#include "train/generator/generator_network.h"

namespace nlg {

// What a checkpoint was made with. Resuming with anything else is refused, naming what differs.
struct RunIdentity {
  std::string representation;
  std::string options_json;  // resolved options of the run
  std::string basis_sha256;
  std::string training_set_sha256;  // FunctionSet::sha256

  bool operator==(const RunIdentity&) const = default;
};

struct TrainingState {
  GeneratorNetwork network{nullptr};  // being trained
  GeneratorNetwork average{nullptr};  // its averaged weights: what is validated and exported
  std::shared_ptr<torch::optim::Adam> optimizer;
  int64_t step = 0;                   // steps done
  int64_t draw = 0;                   // batches drawn: the steps, and what rollbacks left out
  int rollbacks = 0;                  // times that training went back to a good state (loss_guard.h)
  std::vector<double> recent_losses;  // of the last steps
  std::string log_csv;                // one line a validation
};

// Adam's moments in the order of the network's parameters; empty before the first step.
std::vector<torch::optim::AdamParamState*> adamMoments(const TrainingState& state);

// throws OutputError
void writeCheckpoint(const std::string& path, const RunIdentity& identity, const TrainingState& state);

// Loads into a state whose networks and optimizer have been made for the same shape.
// throws InputError when the file is missing, damaged (DamageError), or of another run
void readCheckpoint(const std::string& path, const RunIdentity& identity, TrainingState* state);

// What a checkpoint says of itself. throws InputError as readCheckpoint does
struct CheckpointHead {
  RunIdentity identity;
  int64_t step = 0, rollbacks = 0;
};
CheckpointHead readCheckpointHead(const std::string& path);

// The identity alone, for export: what readCheckpoint needs to be called with; the shape stands in its options.
RunIdentity readIdentity(const std::string& path);

}  // namespace nlg
