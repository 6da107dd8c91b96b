// nlg-datagen's first duty: one scene under one jitter → one shard of weighting functions.
#pragma once

#include <string>

#include "datagen/probes/probe_grid.h"
#include "datagen/scene/jitter.h"
#include "datagen/weighting/weighting_builder.h"
#include "tool/options.h"

namespace nlg {

struct DatagenOptions {
  ProbeGridOptions grid;
  JitterOptions jitter;
  DiffusionOptions diffusion;
  int max_functions = 1200;
  int max_visited_probes = 4000000;
  int unseen_points = 2048;
  uint64_t seed = 1;
};

// Adds every option to the table of the section `datagen`.
void describe(DatagenOptions& options, OptionTable& table);

struct GenerationRequest {
  std::string scene;  // "house:3" or a path
  uint64_t jitter = 0;
  bool held_out = false;
  std::string out;
};

// Generates and writes the shard, and prints its counts on stdout as one line of JSON.
// throws   UsageError, InputError (the scene), OutputError
void generate(const GenerationRequest& request, const DatagenOptions& options, const OptionTable& table);

}  // namespace nlg
