#include "validate/compare/comparison.h"

#include <fmt/format.h>
#include <algorithm>
#include <map>

#include "tool/error.h"
#include "validate/compare/paired_figures.h"
#include "validate/compare/significance.h"

namespace nlg {
namespace {

Change unpairedChange(double old_value, double new_value, double tolerance) {
  Change change;
  change.old_value = old_value;
  change.new_value = new_value;
  change.trend = trendBeyond(old_value, new_value, tolerance);
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
  if (old_run.theta_precision != new_run.theta_precision) {
    throw InputError(new_run.path, "theta_precision", old_run.theta_precision + " as in " + old_run.path,
                     new_run.theta_precision);
  }
  for (const auto& [key, value] : old_run.tau) {
    if (new_run.tau.at(key) != value) {
      throw InputError(new_run.path, "tau." + key, fmt::format("{:g} as in {}", value, old_run.path),
                       fmt::format("{:g}", new_run.tau.at(key)));
    }
  }
}

// Both runs number the functions of a held-out set alike.
void refuseOtherFunctions(const ValidationResult& new_run, const std::string& name, const std::string& word,
                          const std::vector<ComparedFunction>& old_rows, const std::vector<ComparedFunction>& new_rows) {
  const auto is_same = [](const ComparedFunction& a, const ComparedFunction& b) {
    return a.function == b.function && a.scene == b.scene && a.takes_theta == b.takes_theta && a.hard == b.hard;
  };
  if (std::equal(old_rows.begin(), old_rows.end(), new_rows.begin(), new_rows.end(), is_same)) return;
  throw InputError(new_run.path, "rows of '" + name + "', '" + word + "' in functions.csv beside it",
                   "the functions of the old run, in its order", "others");
}

bool takesTheta(const ComparedFunction& function) { return function.takes_theta; }
bool isHard(const ComparedFunction& function) { return function.hard; }

// What a word costs: how many functions took a fit, which is shown and never judged, and the time.
void addCost(const std::string& word, const ComparedRepresentation& old_one, const ComparedRepresentation& new_one,
             const ComparisonOptions& options, std::vector<Change>* changes) {
  const ComparedFigures &a = old_one.figures.at(word), &b = new_one.figures.at(word);
  Change fitted = unpairedChange(a.share_fitted, b.share_fitted, 0.0);
  fitted.trend = Trend::same;
  fitted.figure = word + ", share that took a fit";
  changes->push_back(fitted);
  Change time = unpairedChange(a.us_per_function, b.us_per_function, options.time_tolerance);
  if (options.time_tolerance == 0.0) time.trend = Trend::same;
  time.figure = word + ", µs a function";
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
  for (const std::string word : kComparedWords) {
    const auto &old_rows = old_one.functions.at(word), &new_rows = new_one.functions.at(word);
    refuseOtherFunctions(new_run, old_one.name, word, old_rows, new_rows);
    const PairedFigures& of = figures.emplace(word, PairedFigures(old_rows, new_rows, new_run, options)).first->second;
    add("", word + ", mean RMSE", of.rmse(takesTheta));
    add("", word + ", mean RMSE of hard functions", of.rmse(isHard));
    add("", word + ", p99 of RMSE", of.p99(takesTheta));
    add("", word + ", worst RMSE", of.worst(takesTheta));
    add("", word + ", share that fails the check", of.shareFailingCheck(takesTheta));
    add("", word + ", mean leak of a function", of.leak(takesTheta));
    addCost(word, old_one, new_one, options, changes);
  }
  for (const auto& [scene, _] : old_one.scene_rmse) {
    const auto here = [&scene = scene](const ComparedFunction& f) { return f.takes_theta && f.scene == scene; };
    for (const std::string word : kWordsByScene) {
      const PairedFigures& of = figures.at(word);
      add(scene, word + ", mean RMSE", of.rmse(here));
      add(scene, word + ", worst RMSE", of.worst(here));
      add(scene, word + ", share that fails the check", of.shareFailingCheck(here));
    }
  }
}

// Without the functions of both, a leap of the worst is one above the other run's worst.
Change unpairedWorst(double old_value, double new_value, double tau, double factor) {
  Change change;
  change.old_value = old_value;
  change.new_value = new_value;
  if (new_value > factor * std::max(old_value, tau)) change.trend = Trend::worse;
  if (old_value > factor * std::max(new_value, tau)) change.trend = Trend::better;
  return change;
}

void compareSummaries(const ComparedRepresentation& old_one, const ComparedRepresentation& new_one, double tau_rmse,
                      const ComparisonOptions& options, std::vector<Change>* changes) {
  const auto add = [&](const std::string& scene, const std::string& figure, Change change) {
    change.scene = scene;
    change.figure = figure;
    changes->push_back(std::move(change));
  };
  const auto within = [&](double old_value, double new_value) { return unpairedChange(old_value, new_value, options.tolerance); };
  for (const std::string word : kComparedWords) {
    const ComparedFigures &a = old_one.figures.at(word), &b = new_one.figures.at(word);
    add("", word + ", mean RMSE", within(a.rmse, b.rmse));
    add("", word + ", mean RMSE of hard functions", within(a.rmse_hard, b.rmse_hard));
    add("", word + ", p99 of RMSE", within(a.rmse_p99, b.rmse_p99));
    add("", word + ", worst RMSE", unpairedWorst(a.rmse_worst, b.rmse_worst, tau_rmse, options.worst_factor));
    add("", word + ", share that fails the check", within(a.share_failing_check, b.share_failing_check));
    add("", word + ", mean leak of a point", within(a.leak_mean, b.leak_mean));
    addCost(word, old_one, new_one, options, changes);
  }
  for (const auto& [scene, old_rmse] : old_one.scene_rmse) {
    const auto new_rmse = new_one.scene_rmse.find(scene);
    if (new_rmse == new_one.scene_rmse.end()) continue;
    for (const std::string word : kWordsByScene)
      add(scene, word + ", mean RMSE", within(old_rmse.at(word), new_rmse->second.at(word)));
  }
}

// All figures that have a chance, of all representations, are one family.
void judgeByChance(const ComparisonOptions& options, Comparison* comparison) {
  std::vector<Change*> judged;
  std::vector<double> chances;
  for (Change& change : comparison->changes) {
    if (!change.chance) continue;
    judged.push_back(&change);
    chances.push_back(*change.chance);
  }
  comparison->judged_by_chance = judged.size();
  const std::vector<bool> beyond = beyondChance(chances, options.false_alarms);
  for (size_t i = 0; i < judged.size(); ++i) {
    if (beyond[i]) judged[i]->trend = trendBeyond(judged[i]->old_value, judged[i]->new_value, options.smallest_change);
  }
}

}  // namespace

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
      compareSummaries(old_one, *new_one, new_run.tau.at("rmse"), options, &changes);
    }
    for (Change& change : changes) {
      change.representation = old_one.name;
      result.changes.push_back(std::move(change));
    }
  }
  judgeByChance(options, &result);
  if (result.changes.empty()) throw InputError(new_run.path, "representations", "at least one of " + old_run.path, "none");
  return result;
}

}  // namespace nlg
