// Saves and resumes the state of a training run: written atomically, resumed bit for bit.
#pragma once

#include <string>

#include "train/generator/checkpoint_file.h"
#include "train/generator/generator_update.h"

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

}  // namespace nlg
