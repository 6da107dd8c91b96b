// Two runs of nlg-validate on the same held-out functions: what got better or worse, beyond noise.
#pragma once

#include <string>
#include <vector>

#include "validate/comparison/validation_result.h"

namespace nlg {

// What counts as noise. Errors are those of the same functions in both runs, so the noise is that of the choice of functions: would
// another held-out set of the same kind say the same? With the values of every function, a mean has changed when the mean of the
// paired differences is more than `standard_errors` of these differences from 0; by chance that happens to a figure once in 2000
// times. And always: by more than `smallest_change` of the old value, or nobody would notice.
struct ComparisonOptions {
  double standard_errors = 3.5;
  double smallest_change = 0.01;
  double tolerance = 0.05;      // share of the old value that may be noise where values of single functions are missing
  double time_tolerance = 0.0;  // the same for times, which a busy machine changes; 0: times are shown, never judged
};

enum class Trend { better, same, worse };

// One figure in both runs; lower is better.
struct Change {
  std::string representation;
  std::string scene;   // empty: all held-out functions
  std::string figure;  // "generator, mean RMSE"
  double old_value = 0, new_value = 0;
  double standard_error = 0;  // of new_value - old_value; 0 where it is not known
  Trend trend = Trend::same;
};

struct Comparison {
  bool is_paired = false;                // by functions.csv of both
  std::vector<std::string> lost, added;  // representations that only the old or only the new run has
  std::vector<Change> changes;           // by representation: all functions, then scene by scene
};

// Means of fewer pairs than this are judged by the tolerance: their spread is not known well enough.
inline constexpr size_t kFewestPairs = 8;

// throws   InputError naming the new file where it is of other held-out functions, of other thresholds, or has no representation
//          in common with the old one
Comparison compare(const ValidationResult& old_run, const ValidationResult& new_run, const ComparisonOptions& options);

// How a mean over functions changed, by the rule of ComparisonOptions.
// old_values, new_values   of the same functions, in the same order
Change pairedChange(const std::vector<double>& old_values, const std::vector<double>& new_values,
                    const ComparisonOptions& options);

}  // namespace nlg
