// What nlg-validate wrote of one run, as far as two runs are compared by it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace nlg {

// One function under one method: a row of functions.csv.
struct ComparedFunction {
  uint64_t function = 0;
  std::string scene;
  bool hard = false;
  double rmse = 0, leak_mean = 0, leak_p99 = 0;
};

// The figures of one method over all held-out functions, from summary.json.
struct ComparedFigures {
  double rmse = 0, rmse_p99 = 0, rmse_worst = 0, rmse_hard = 0, share_over_tau = 0, leak_mean = 0, us_per_function = 0;
};

// The methods that are compared, those of what ships: the generator, and what a bake makes of it.
inline constexpr const char* kComparedMethods[] = {"generator", "refined"};

struct ComparedRepresentation {
  std::string name;
  std::map<std::string, ComparedFigures> figures;  // by method
  std::map<std::string, double> scene_rmse;        // mean of the generator's RMSE, by scene
  std::map<std::string, std::vector<ComparedFunction>>
      functions;  // by method, in the order of the file; empty without functions.csv
};

struct ValidationResult {
  std::string path;      // of summary.json
  std::string held_out;  // hash of the held-out shards as a set
  std::map<std::string, double> tau;
  bool has_functions = false;  // functions.csv lies beside it
  std::vector<ComparedRepresentation> representations;
};

// Reads summary.json, and functions.csv of the same folder where there is one.
// throws   InputError naming file and place: not readable, another schema_version, a figure that is missing or no finite number, a
//          row that is damaged, a method with other rows than the summary counts
ValidationResult readValidation(const std::string& summary_path);

}  // namespace nlg
