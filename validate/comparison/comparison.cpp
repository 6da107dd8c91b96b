#include "validate/comparison/comparison.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>

#include "tool/error.h"

namespace nlg {
namespace {

Trend trendOf(double difference, double threshold) {
  if (std::fabs(difference) <= threshold) return Trend::same;
  return difference < 0 ? Trend::better : Trend::worse;
}

Change unpairedChange(double old_value, double new_value, double tolerance) {
  Change change;
  change.old_value = old_value;
  change.new_value = new_value;
  change.trend = trendOf(new_value - old_value, tolerance * old_value);
  return change;
}

const ComparedRepresentation* find(const ValidationResult& run, const std::string& name) {
  for (const ComparedRepresentation& representation : run.representations) {
    if (representation.name == name) return &representation;
  }
  return nullptr;
}

void refuseOtherRuns(const ValidationResult& old_run, const ValidationResult& new_run) {
  if (old_run.held_out != new_run.held_out) {
    throw InputError(new_run.path, "provenance.inputs.held_out",
                     "the held-out functions of " + old_run.path + ", " + old_run.held_out, new_run.held_out);
  }
  for (const auto& [key, value] : old_run.tau) {
    if (new_run.tau.at(key) != value) {
      throw InputError(new_run.path, "tau." + key, fmt::format("{:g} as in {}", value, old_run.path),
                       fmt::format("{:g}", new_run.tau.at(key)));
    }
  }
}

// Both runs number the functions of a held-out set alike.
void refuseOtherFunctions(const ValidationResult& new_run, const std::string& name, const std::string& method,
                          const std::vector<ComparedFunction>& old_rows, const std::vector<ComparedFunction>& new_rows) {
  const auto is_same = [](const ComparedFunction& a, const ComparedFunction& b) {
    return a.function == b.function && a.scene == b.scene && a.hard == b.hard;
  };
  if (std::equal(old_rows.begin(), old_rows.end(), new_rows.begin(), new_rows.end(), is_same)) return;
  throw InputError(new_run.path, "rows of '" + name + "', '" + method + "' in functions.csv beside it",
                   "the functions of the old run, in its order", "others");
}

// The figures of one method on some of the functions.
class PairedFigures {
 public:
  PairedFigures(const std::vector<ComparedFunction>& old_rows, const std::vector<ComparedFunction>& new_rows,
                const ValidationResult& run, const ComparisonOptions& options)
      : old_rows_(old_rows),
        new_rows_(new_rows),
        tau_rmse_(run.tau.at("rmse")),
        tau_leak_(run.tau.at("leak_p99")),
        options_(options) {}

  using Choice = std::function<bool(const ComparedFunction&)>;
  Change rmse(const Choice& chosen) const {
    return change(chosen, [](const ComparedFunction& f) { return f.rmse; });
  }
  Change leak(const Choice& chosen) const {
    return change(chosen, [](const ComparedFunction& f) { return f.leak_mean; });
  }
  Change shareOverTau(const Choice& chosen) const {
    return change(chosen, [&](const ComparedFunction& f) { return f.rmse > tau_rmse_ || f.leak_p99 > tau_leak_ ? 1.0 : 0.0; });
  }

 private:
  Change change(const Choice& chosen, const std::function<double(const ComparedFunction&)>& value) const {
    std::vector<double> old_values, new_values;
    for (size_t i = 0; i < old_rows_.size(); ++i) {
      if (!chosen(old_rows_[i])) continue;
      old_values.push_back(value(old_rows_[i]));
      new_values.push_back(value(new_rows_[i]));
    }
    return pairedChange(old_values, new_values, options_);
  }

  const std::vector<ComparedFunction>&old_rows_, &new_rows_;
  double tau_rmse_, tau_leak_;
  ComparisonOptions options_;
};

void addTime(const std::string& method, const ComparedRepresentation& old_one, const ComparedRepresentation& new_one,
             const ComparisonOptions& options, std::vector<Change>* changes) {
  Change time = unpairedChange(old_one.figures.at(method).us_per_function, new_one.figures.at(method).us_per_function,
                               options.time_tolerance);
  if (options.time_tolerance == 0.0) time.trend = Trend::same;
  time.figure = method + ", µs a function";
  changes->push_back(time);
}

void comparePaired(const ComparedRepresentation& old_one, const ComparedRepresentation& new_one, const ValidationResult& new_run,
                   const ComparisonOptions& options, std::vector<Change>* changes) {
  const auto add = [&](const std::string& scene, const std::string& figure, Change change) {
    change.scene = scene;
    change.figure = figure;
    changes->push_back(change);
  };
  std::map<std::string, PairedFigures> figures;
  for (const std::string method : kComparedMethods) {
    const auto &old_rows = old_one.functions.at(method), &new_rows = new_one.functions.at(method);
    refuseOtherFunctions(new_run, old_one.name, method, old_rows, new_rows);
    figures.emplace(method, PairedFigures(old_rows, new_rows, new_run, options));
  }
  const auto all = [](const ComparedFunction&) { return true; };
  for (const auto& [method, of] : figures) {
    add("", method + ", mean RMSE", of.rmse(all));
    add("", method + ", mean RMSE of hard functions", of.rmse([](const ComparedFunction& f) { return f.hard; }));
    add("", method + ", share over tau", of.shareOverTau(all));
    add("", method + ", mean leak of a function", of.leak(all));
    addTime(method, old_one, new_one, options, changes);
  }
  for (const auto& [scene, _] : old_one.scene_rmse) {
    const auto here = [&scene = scene](const ComparedFunction& f) { return f.scene == scene; };
    for (const auto& [method, of] : figures) {
      add(scene, method + ", mean RMSE", of.rmse(here));
      add(scene, method + ", share over tau", of.shareOverTau(here));
    }
  }
}

void compareSummaries(const ComparedRepresentation& old_one, const ComparedRepresentation& new_one,
                      const ComparisonOptions& options, std::vector<Change>* changes) {
  const auto add = [&](const std::string& scene, const std::string& figure, double old_value, double new_value) {
    Change change = unpairedChange(old_value, new_value, options.tolerance);
    change.scene = scene;
    change.figure = figure;
    changes->push_back(change);
  };
  for (const std::string method : kComparedMethods) {
    const ComparedFigures &a = old_one.figures.at(method), &b = new_one.figures.at(method);
    add("", method + ", mean RMSE", a.rmse, b.rmse);
    add("", method + ", mean RMSE of hard functions", a.rmse_hard, b.rmse_hard);
    add("", method + ", share over tau", a.share_over_tau, b.share_over_tau);
    add("", method + ", mean leak of a point", a.leak_mean, b.leak_mean);
    addTime(method, old_one, new_one, options, changes);
  }
  for (const auto& [scene, rmse] : old_one.scene_rmse) {
    const auto other = new_one.scene_rmse.find(scene);
    if (other != new_one.scene_rmse.end()) add(scene, "generator, mean RMSE", rmse, other->second);
  }
}

}  // namespace

Change pairedChange(const std::vector<double>& old_values, const std::vector<double>& new_values,
                    const ComparisonOptions& options) {
  NLG_CHECK(old_values.size(), ==, new_values.size());
  const size_t count = old_values.size();
  if (count == 0) return {};
  const auto pairs = static_cast<double>(count);
  double old_sum = 0.0, new_sum = 0.0, squares = 0.0;
  for (size_t i = 0; i < count; ++i) {
    old_sum += old_values[i];
    new_sum += new_values[i];
  }
  const double difference = (new_sum - old_sum) / pairs;
  for (size_t i = 0; i < count; ++i) squares += std::pow(new_values[i] - old_values[i] - difference, 2.0);
  if (count < kFewestPairs) return unpairedChange(old_sum / pairs, new_sum / pairs, options.tolerance);
  Change change;
  change.old_value = old_sum / pairs;
  change.new_value = new_sum / pairs;
  change.standard_error = std::sqrt(squares / (pairs - 1.0) / pairs);
  change.trend =
      trendOf(difference, std::max(options.standard_errors * change.standard_error, options.smallest_change * change.old_value));
  return change;
}

Comparison compare(const ValidationResult& old_run, const ValidationResult& new_run, const ComparisonOptions& options) {
  refuseOtherRuns(old_run, new_run);
  Comparison result;
  result.is_paired = old_run.has_functions && new_run.has_functions;
  for (const ComparedRepresentation& new_one : new_run.representations) {
    if (!find(old_run, new_one.name)) result.added.push_back(new_one.name);
  }
  for (const ComparedRepresentation& old_one : old_run.representations) {
    const ComparedRepresentation* new_one = find(new_run, old_one.name);
    if (!new_one) {
      result.lost.push_back(old_one.name);
      continue;
    }
    std::vector<Change> changes;
    if (result.is_paired) {
      comparePaired(old_one, *new_one, new_run, options, &changes);
    } else {
      compareSummaries(old_one, *new_one, options, &changes);
    }
    for (Change& change : changes) {
      change.representation = old_one.name;
      result.changes.push_back(std::move(change));
    }
  }
  if (result.changes.empty()) throw InputError(new_run.path, "representations", "at least one of " + old_run.path, "none");
  return result;
}

}  // namespace nlg
