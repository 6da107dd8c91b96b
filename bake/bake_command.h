// The command nlg-bake: its request, its bake, and what its bake, relight (again/relight.h) and check (again/check.h) do alike.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "bake/light_bake.h"
#include "bake/prepared_scene.h"
#include "nlg/generator.h"
#include "tool/command/options.h"

namespace nlg {

struct BakeRequest {
  std::string scene, out, config, json;  // files; json: "-" is standard output
  std::string inputs;                    // a file to name all others in that were read
  std::string collect;                   // a folder for a shard of the functions that fail the check; empty: there is none
  std::string relit;                     // a grid whose light is made anew; empty: everything is
  std::string checked;                   // a grid that is only asked whether it is what would be baked
  std::vector<std::string> weights;
  bool out_is_given = false;
};

// Bakes, relights or checks, and whatever comes of it lists the inputs, where asked.
// table    of the options, with their values
// throws   every error of tool/error.h
void runBakeCommand(const BakeRequest& request, const BakeOptions& options, const OptionTable& table);

// Before anything is read: a bake takes minutes.
// inputs   files that are read
// throws   UsageError, OutputError on outputs that cannot be written, or would replace an input or somebody else's file
void checkOutputs(const BakeRequest& request, const std::vector<std::string>& inputs);

struct NamedGenerators {
  std::vector<Generator> generators;          // by rising number of parameters
  std::vector<std::string> paths;             // by generator
  std::map<std::string, std::string> sha256;  // by kWeightsRole + representation
};
NamedGenerators loadGeneratorsOf(const BakeRequest& request);

// Says on stderr what was read, how it is lit, and what the bake is going to take.
// generators   of the functions that will be made; none: light alone is
PreparedScene prepareScene(const BakeRequest& request, const BakeOptions& options, const std::vector<Generator>& generators,
                           const KnownAir& known = {});

// Writes the grid; returns the file's bytes.
uint64_t writeGrid(const BakeRequest& request, const LightGrid& grid, const BakeOptions& options, const GridMetadata& metadata);

// Says on stderr what the light came to without an error, and is seldom meant.
void warnOfLight(const PreparedScene& scene, const BakeOptions& options, const LightStatistics& statistics);

// Writes a report where the request asks for it.
void writeJson(const BakeRequest& request, const nlohmann::ordered_json& json);

// Of this process, so far.
uint64_t peakMemoryBytes();

}  // namespace nlg
