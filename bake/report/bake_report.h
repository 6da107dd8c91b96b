// Reports of a bake: a summary for everybody, one line of JSON for programs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake/scene_bake.h"

namespace nlg {

// What a bake left out because its scene did not need it, one line for each kind.
//
// Seconds and bytes are counts times what the same work, or the same thing, took in this bake on average. Functions that were not made
// may well have been cheaper or dearer than those that were: the figures say what a saving is worth, not what another bake would show.
struct Saving {
  std::string what;            // one of the names of docs/reference/bake_json.md
  uint64_t count = 0, of = 0;  // how many were left out, of how many
  // Of the processor, all threads together. Below 0 where finding out took longer than it saved. Nothing where the bake did none of
  // that work, and so does not know what it costs.
  std::optional<double> seconds;
  std::optional<int64_t> bytes;  // of the light grid's file; of representations never chosen, of their weights
  std::string note;
};

// generators   those of the bake, and weights_bytes the sizes of their files, in the same order
// stored       what the file holds theta and light in
// threads      of the bake
std::vector<Saving> savingsOf(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
                              const GridPrecision& stored, const std::vector<uint64_t>& weights_bytes, int threads);

// An object each; seconds_saved and bytes_saved only where they are known. Keys: docs/reference/bake_json.md.
nlohmann::ordered_json toJson(const std::vector<Saving>& savings);

// A weights file that a bake was given.
struct WeightsUsed {
  std::string representation, sha256;
  uint64_t bytes = 0;
};

struct BakeReport {
  std::string scene;
  size_t notes = 0;                  // on how the scene's file was read: told when it was
  std::vector<WeightsUsed> weights;  // by rising number of parameters
  BakeStatistics statistics;
  std::vector<Saving> savings;
  PolicyOptions policy;
  uint64_t file_bytes = 0, theta_bytes = 0;
  uint64_t peak_memory_bytes = 0;
  int threads = 1;
  std::string simd;
};

// The same of a bake that made light alone.
struct RelightReport {
  std::string scene, grid;  // the path of the grid that had the functions
  uint64_t probes = 0, file_bytes = 0, peak_memory_bytes = 0;
  double wall_s = 0.0;
  size_t notes = 0;
  LightStatistics light;
};
nlohmann::ordered_json toJson(const RelightReport& report);
std::string toSummary(const RelightReport& report, const std::string& path);

// Keys: docs/reference/bake_json.md.
nlohmann::ordered_json toJson(const BakeReport& report);

// The lines that a bake ends with, three or four.
// path   of the light grid
std::string toSummary(const BakeReport& report, const std::string& path);

}  // namespace nlg
