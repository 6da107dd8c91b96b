// nlg-validate stability: every stiff and extreme case with what must hold and what was measured, as one JSON file.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "validate/stability/stability_case.h"

namespace nlg {

struct StabilityRequest {
  std::vector<std::string> weights;  // exported generators; without any the cases that need them are not run
  std::string training;              // what training_cases.py wrote; empty: the training cases are not run
  std::string only;                  // one group; empty: all
  StabilityDepth depth = StabilityDepth::full;
};

struct StabilityReport {
  nlohmann::ordered_json cases;     // docs/reference/formats.md
  std::vector<std::string> failed;  // names of cases that ran and did not hold
  int passed = 0, not_run = 0;
};

// Runs the suite; says on stderr what it is at when that is a terminal. A case that throws fails with the exception's line.
// throws   UsageError on a group that does not exist or two weights of one representation; InputError on weights or a training file that cannot be read
StabilityReport runStability(const StabilityRequest& request);

// The subcommand. returns the exit code: check_failed, after the file is written, when some case did not hold
int stabilityMain(int argc, char** argv);

}  // namespace nlg
