// Reports of a bake: a summary for everybody, one line of JSON for programs.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "bake/report/savings.h"
#include "bake/scene_bake.h"

namespace nlg {

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
