// The figures of the same functions in two runs, and how likely noise alone makes their differences.
//
// Under noise alone each function's two errors could as well stand the other way round, and functions do so independently.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "validate/compare/change.h"
#include "validate/compare/validation_result.h"

namespace nlg {

// A mean over functions. Its chance is that of Student's t of the mean of the paired differences over its standard error, but never
// below 2^(1 - pairs), the chance that so many go the same way: t alone believes a few pairs that agree more than that.
// old_values, new_values   of the same functions, in the same order
Change meanChange(const std::vector<double>& old_values, const std::vector<double>& new_values);

// The 99th percentile. Its chance is that of the sign test between the functions that rose above and those that fell below the 99th
// percentile of both runs' values together, which favours neither run.
Change p99Change(const std::vector<double>& old_values, const std::vector<double>& new_values);

// The figures of one word; of each of them on the functions that are chosen.
class PairedFigures {
 public:
  // old_rows, new_rows   of the same functions in the same order; they must outlive this object
  PairedFigures(const std::vector<ComparedFunction>& old_rows, const std::vector<ComparedFunction>& new_rows,
                const ValidationResult& run, const ComparisonOptions& options);

  using Choice = std::function<bool(const ComparedFunction&)>;
  Change rmse(const Choice& chosen) const;
  Change leak(const Choice& chosen) const;
  Change p99(const Choice& chosen) const;
  // Sign test between the functions that came to fail the check and those that came to pass it.
  Change shareFailingCheck(const Choice& chosen) const;
  // Worse where any function leaps: its new RMSE is above worst_factor times the larger of its old one and tau. Better where none
  // does, and some would the other way round. What these very functions do is no matter of chance.
  Change worst(const Choice& chosen) const;

 private:
  using Value = std::function<double(const ComparedFunction&)>;
  std::vector<double> values(const std::vector<ComparedFunction>& rows, const Choice& chosen, const Value& value) const;
  bool leaps(const ComparedFunction& from, const ComparedFunction& to) const;

  const std::vector<ComparedFunction>&old_rows_, &new_rows_;
  double tau_rmse_, worst_factor_;
};

}  // namespace nlg
