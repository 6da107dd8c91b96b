#include "validate/compare/paired_figures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tool/error.h"
#include "validate/compare/significance.h"
#include "validate/errors/statistics.h"

namespace nlg {
namespace {

// Judges by how many functions rose above a threshold and how many fell to it or below.
void judgeCrossings(const std::vector<double>& old_values, const std::vector<double>& new_values, double threshold,
                    Change* change) {
  uint64_t risen = 0, fallen = 0;
  for (size_t i = 0; i < old_values.size(); ++i) {
    risen += old_values[i] <= threshold && new_values[i] > threshold;
    fallen += old_values[i] > threshold && new_values[i] <= threshold;
  }
  change->chance = signChance(risen, fallen);
  if (risen + fallen > 0) change->note = fmt::format("{} rose above it, {} fell below", risen, fallen);
}

}  // namespace

Change meanChange(const std::vector<double>& old_values, const std::vector<double>& new_values) {
  NLG_CHECK(old_values.size(), ==, new_values.size());
  if (old_values.empty()) return {};
  const auto pairs = static_cast<double>(old_values.size());
  Change change;
  change.old_value = mean(old_values);
  change.new_value = mean(new_values);
  change.chance = 1.0;
  const double difference = change.new_value - change.old_value;
  if (old_values.size() == 1 || difference == 0.0) return change;
  double squares = 0.0;
  for (size_t i = 0; i < old_values.size(); ++i) squares += std::pow(new_values[i] - old_values[i] - difference, 2.0);
  change.standard_error = std::sqrt(squares / (pairs - 1.0) / pairs);
  const double t = change.standard_error > 0.0 ? difference / change.standard_error : std::numeric_limits<double>::infinity();
  change.chance = std::max(studentChance(t, pairs - 1.0), std::pow(2.0, 1.0 - pairs));
  return change;
}

Change p99Change(const std::vector<double>& old_values, const std::vector<double>& new_values) {
  NLG_CHECK(old_values.size(), ==, new_values.size());
  if (old_values.empty()) return {};
  Change change;
  std::vector<double> old_sorted = old_values, new_sorted = new_values, both = old_values;
  both.insert(both.end(), new_values.begin(), new_values.end());
  change.old_value = quantile(old_sorted, 0.99);
  change.new_value = quantile(new_sorted, 0.99);
  judgeCrossings(old_values, new_values, quantile(both, 0.99), &change);
  return change;
}

PairedFigures::PairedFigures(const std::vector<ComparedFunction>& old_rows, const std::vector<ComparedFunction>& new_rows,
                             const ValidationResult& run, const ComparisonOptions& options)
    : old_rows_(old_rows), new_rows_(new_rows), tau_rmse_(run.tau.at("rmse")), worst_factor_(options.worst_factor) {
  NLG_CHECK(old_rows.size(), ==, new_rows.size());
}

std::vector<double> PairedFigures::values(const std::vector<ComparedFunction>& rows, const Choice& chosen,
                                          const Value& value) const {
  std::vector<double> result;
  for (const ComparedFunction& row : rows) {
    if (chosen(row)) result.push_back(value(row));
  }
  return result;
}

Change PairedFigures::rmse(const Choice& chosen) const {
  const auto value = [](const ComparedFunction& f) { return f.rmse; };
  return meanChange(values(old_rows_, chosen, value), values(new_rows_, chosen, value));
}

Change PairedFigures::leak(const Choice& chosen) const {
  const auto value = [](const ComparedFunction& f) { return f.leak_mean; };
  return meanChange(values(old_rows_, chosen, value), values(new_rows_, chosen, value));
}

Change PairedFigures::p99(const Choice& chosen) const {
  const auto value = [](const ComparedFunction& f) { return f.rmse; };
  return p99Change(values(old_rows_, chosen, value), values(new_rows_, chosen, value));
}

Change PairedFigures::shareFailingCheck(const Choice& chosen) const {
  const auto fails = [](const ComparedFunction& f) { return f.fails_check ? 1.0 : 0.0; };
  const std::vector<double> old_fails = values(old_rows_, chosen, fails), new_fails = values(new_rows_, chosen, fails);
  if (old_fails.empty()) return {};
  Change change;
  change.old_value = mean(old_fails);
  change.new_value = mean(new_fails);
  judgeCrossings(old_fails, new_fails, 0.5, &change);
  return change;
}

bool PairedFigures::leaps(const ComparedFunction& from, const ComparedFunction& to) const {
  return to.rmse > worst_factor_ * std::max(from.rmse, tau_rmse_);
}

Change PairedFigures::worst(const Choice& chosen) const {
  Change change;
  uint64_t risen = 0, fallen = 0;
  size_t highest = 0;  // of those that leapt up
  for (size_t i = 0; i < old_rows_.size(); ++i) {
    const ComparedFunction &old_one = old_rows_[i], &new_one = new_rows_[i];
    if (!chosen(old_one)) continue;
    change.old_value = std::max(change.old_value, old_one.rmse);
    change.new_value = std::max(change.new_value, new_one.rmse);
    fallen += leaps(new_one, old_one);
    if (!leaps(old_one, new_one)) continue;
    if (risen++ == 0 || new_one.rmse > new_rows_[highest].rmse) highest = i;
  }
  if (risen > 0) {
    const ComparedFunction &from = old_rows_[highest], &to = new_rows_[highest];
    change.note = fmt::format("{} leapt, the highest function {} of {}: {:.5g} -> {:.5g}", risen, to.function, to.scene,
                              from.rmse, to.rmse);
  } else if (fallen > 0) {
    change.note = fmt::format("{} no longer so high", fallen);
  }
  change.trend = risen > 0 ? Trend::worse : fallen > 0 ? Trend::better : Trend::same;
  return change;
}

}  // namespace nlg
