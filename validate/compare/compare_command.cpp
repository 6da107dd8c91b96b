#include "validate/compare/compare_command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "tool/tool_main.h"
#include "validate/compare/comparison.h"

namespace nlg {
namespace {

struct Request {
  std::string old_path, new_path;
  bool json = false, all_scenes = false;
};

const char* nameOf(Trend trend) {
  switch (trend) {
    case Trend::better:
      return "better";
    case Trend::worse:
      return "worse";
    case Trend::same:
      return "same";
  }
  return "";
}

size_t countOf(const Comparison& comparison, Trend trend) {
  size_t count = 0;
  for (const Change& change : comparison.changes) count += change.trend == trend;
  return count;
}

std::string placeOf(const Change& change) {
  return change.representation + (change.scene.empty() ? "" : ", " + change.scene) + ": " + change.figure;
}

void printText(const Comparison& comparison, const ComparisonOptions& options, bool all_scenes) {
  if (comparison.is_paired) {
    std::cout << fmt::format(
        "of functions that take a theta; noise: a chance of at most {:g} that it has any of the {} figures judged by chance "
        "called "
        "changed; and {:g} % of the old value\n",
        options.false_alarms, comparison.judged_by_chance, 100.0 * options.smallest_change);
  } else {
    std::cout << fmt::format(
        "of functions that take a theta; noise: {:g} % of the old value; no functions.csv beside both files to pair functions "
        "by\n",
        100.0 * options.tolerance);
  }
  std::string representation;
  for (const Change& change : comparison.changes) {
    if (!change.scene.empty() && change.trend == Trend::same && !all_scenes) continue;
    if (change.representation != representation) std::cout << '\n' << (representation = change.representation) << '\n';
    const double difference = change.new_value - change.old_value;
    const double percent = change.old_value != 0.0 ? 100.0 / change.old_value : 0.0;
    const std::string where = (change.scene.empty() ? "" : change.scene + ": ") + change.figure;
    std::string line =
        fmt::format("  {:<7}{:<48} {:>10.5g} -> {:<10.5g}", nameOf(change.trend), where, change.old_value, change.new_value);
    if (percent != 0.0) line += fmt::format(" {:+.1f} %", percent * difference);
    if (percent != 0.0 && change.standard_error > 0.0)
      line += fmt::format(" (standard error {:.1f} %)", percent * change.standard_error);
    if (change.chance && change.old_value != change.new_value) line += fmt::format(", chance {:.2g}", *change.chance);
    if (!change.note.empty()) line += "; " + change.note;
    std::cout << line << '\n';
  }
  std::cout << '\n';
  for (const std::string& name : comparison.lost) std::cout << fmt::format("worse: {} is in the old run only\n", name);
  for (const std::string& name : comparison.added) std::cout << fmt::format("{} is in the new run only\n", name);
  std::cout << fmt::format("{} better, {} worse, {} the same\n", countOf(comparison, Trend::better),
                           countOf(comparison, Trend::worse) + comparison.lost.size(), countOf(comparison, Trend::same));
}

void printJson(const Comparison& comparison, const ComparisonOptions& options) {
  nlohmann::ordered_json json = {
      {"schema_version", 2}, {"paired", comparison.is_paired}, {"lost", comparison.lost}, {"added", comparison.added}};
  if (comparison.is_paired) json["false_alarms"] = options.false_alarms;
  json["judged_by_chance"] = comparison.judged_by_chance;
  json["changes"] = nlohmann::ordered_json::array();
  for (const Change& change : comparison.changes) {
    json["changes"].push_back({{"representation", change.representation},
                               {"scene", change.scene},
                               {"figure", change.figure},
                               {"old", change.old_value},
                               {"new", change.new_value},
                               {"standard_error", change.standard_error},
                               {"chance", change.chance ? nlohmann::ordered_json(*change.chance) : nlohmann::ordered_json()},
                               {"note", change.note},
                               {"trend", nameOf(change.trend)}});
  }
  std::cout << json.dump() << '\n';
}

// The exit code's reason, in one line.
void refuseWhatIsWorse(const Comparison& comparison) {
  const size_t count = countOf(comparison, Trend::worse) + comparison.lost.size();
  if (count == 0) return;
  std::string first = comparison.lost.empty() ? "" : comparison.lost.front() + " is gone";
  for (const Change& change : comparison.changes) {
    if (first.empty() && change.trend == Trend::worse) first = placeOf(change);
  }
  throw CheckFailed("new run against old", "nothing worse beyond noise",
                    fmt::format("{} worse, the first of them {}", count, first));
}

}  // namespace

int compareMain(int argc, char** argv) {
  CLI::App app{
      "Says what got better or worse between two validations of the same held-out functions, beyond noise, of network, "
      "corrected, "
      "fitted and stored; exit code 6 where "
      "something is worse.",
      "nlg-validate compare"};
  Request request;
  ComparisonOptions options;
  OptionTable table("validate");
  app.add_option("old", request.old_path, "summary.json of the run to compare with")->required();
  app.add_option("new", request.new_path,
                 "summary.json of the run to judge; functions are paired by the functions.csv beside both")
      ->required();
  app.add_option("--false-alarms", options.false_alarms,
                 "paired: the chance that noise alone has anything at all called changed; above 0, below 1")
      ->capture_default_str()
      ->check(CLI::Range(1e-12, 0.999));
  app.add_option("--smallest-change", options.smallest_change, "share of the old value below which a change is none")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--worst-factor", options.worst_factor,
                 "worse where a function's RMSE is above so many times its old one, and tau")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1e6));
  app.add_option("--tolerance", options.tolerance, "the same where functions cannot be paired")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--time-tolerance", options.time_tolerance, "the same for times; 0: they are shown, never judged")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1000.0));
  app.add_flag("--all-scenes", request.all_scenes, "print scenes where nothing changed too");
  app.add_flag("--json", request.json, "one line of JSON");
  return runTool(argc, argv, app, table, [&] {
    const ValidationResult old_run = readValidation(request.old_path);
    const Comparison comparison = compare(old_run, readValidation(request.new_path), options);
    if (request.json) {
      printJson(comparison, options);
    } else {
      printText(comparison, options, request.all_scenes);
    }
    refuseWhatIsWorse(comparison);
  });
}

}  // namespace nlg
