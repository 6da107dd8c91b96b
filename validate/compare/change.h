// How one figure changed between two runs of nlg-validate, and what counts as a change.
#pragma once

#include <optional>
#include <string>

namespace nlg {

// What counts as noise. Errors are those of the same functions in both runs, so the noise is that of the choice of functions: would
// another held-out set of the same kind say the same? With the values of every function each figure has the chance that noise alone
// makes so large a difference (paired_figures.h), and those are changes that pass Holm's method over all figures together
// (significance.h). And always: by more than `smallest_change` of the old value, or nobody would notice.
struct ComparisonOptions {
  double false_alarms = 0.05;  // the chance that noise alone has anything at all called changed; 0 < it < 1
  double smallest_change = 0.01;
  double worst_factor = 2.0;    // a function leaps when its RMSE is above so many times its error in the other run, and tau
  double tolerance = 0.05;      // share of the old value that may be noise where values of single functions are missing
  double time_tolerance = 0.0;  // the same for times, which a busy machine changes; 0: times are shown, never judged
};

enum class Trend { better, same, worse };

// One figure in both runs; lower is better.
struct Change {
  std::string representation;
  std::string scene;   // empty: all held-out functions that the figure is of
  std::string figure;  // "stored, mean RMSE"
  double old_value = 0, new_value = 0;
  double standard_error = 0;     // of new_value - old_value; 0 where it is not known
  std::optional<double> chance;  // that noise alone makes so large a difference; nothing: judged by a tolerance or a factor
  std::string note;              // what it was judged by, where the values do not tell
  Trend trend = Trend::same;     // where there is a chance: `same` until all figures are judged together
};

// By more than a share of the old value.
inline Trend trendBeyond(double old_value, double new_value, double share) {
  const double difference = new_value - old_value;
  if ((difference < 0 ? -difference : difference) <= share * old_value) return Trend::same;
  return difference < 0 ? Trend::better : Trend::worse;
}

}  // namespace nlg
