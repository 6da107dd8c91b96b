// What nlg-validate wrote of one run, as far as two runs are compared by it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace nlg {

// The schema_version that is read: results of different schemas say different things, and are not compared.
inline constexpr int kComparedSchemaVersion = 2;

// The words that are compared, in their order: stages of a function on its way into the grid.
inline constexpr const char* kComparedWords[] = {"network", "corrected", "fitted", "stored"};
// Those that are compared scene by scene: what training makes, and what ships.
inline constexpr const char* kWordsByScene[] = {"network", "stored"};

// One function at one stage: a row of functions.csv.
struct ComparedFunction {
  uint64_t function = 0;
  std::string scene;
  bool takes_theta = false, hard = false;
  double rmse = 0, leak_mean = 0;
  bool fails_check = false;
};

// The figures of one word over the functions that take a theta, from summary.json; rmse_hard: over the hard ones.
struct ComparedFigures {
  double rmse = 0, rmse_p99 = 0, rmse_worst = 0, rmse_hard = 0, share_failing_check = 0, share_fitted = 0, leak_mean = 0,
         us_per_function = 0;
};

struct ComparedRepresentation {
  std::string name;
  std::map<std::string, ComparedFigures> figures;                   // by word
  std::map<std::string, std::map<std::string, double>> scene_rmse;  // mean RMSE, by scene and word of kWordsByScene
  std::map<std::string, std::vector<ComparedFunction>>
      functions;  // by word, in the order of the file; empty without functions.csv
};

struct ValidationResult {
  std::string path;      // of summary.json
  std::string held_out;  // hash of the held-out shards as a set
  std::map<std::string, double> tau;
  std::string theta_precision;
  bool has_functions = false;  // functions.csv lies beside it
  std::vector<ComparedRepresentation> representations;
};

// Reads summary.json, and functions.csv of the same folder where there is one.
// throws   InputError naming file and place: not readable, another schema_version, a figure that is missing or no finite number, a
//          row that is damaged, a word with other rows than the summary counts
ValidationResult readValidation(const std::string& summary_path);

}  // namespace nlg
