// Two runs of nlg-validate on the same held-out functions: what got better or worse, beyond noise.
#pragma once

#include <string>
#include <vector>

#include "validate/compare/change.h"
#include "validate/compare/validation_result.h"

namespace nlg {

struct Comparison {
  bool is_paired = false;                // by functions.csv of both
  std::vector<std::string> lost, added;  // representations that only the old or only the new run has
  size_t judged_by_chance = 0;           // figures: N of Holm's method
  std::vector<Change> changes;           // by representation: all functions, then scene by scene
};

// throws   InputError naming the new file where it is of other held-out functions, of other thresholds, or has no representation
//          in common with the old one
Comparison compare(const ValidationResult& old_run, const ValidationResult& new_run, const ComparisonOptions& options);

}  // namespace nlg
