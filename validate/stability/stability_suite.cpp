#include "validate/stability/stability_suite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <set>

#include <fmt/format.h>

#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/one_file_each.h"
#include "tool/progress.h"
#include "validate/errors/held_out.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 6> kGroups = {"functions", "optimisers", "pca", "generator", "scenes", "training"};

// What the file of training_cases.py lacks when there is none; the script's own list, so that the table shows what is missing.
constexpr std::array<const char*, 7> kTrainingCases = {
    "poisoned batch",      "poisoned batches without end", "exploding learning rate",       "extreme targets",
    "shard that vanishes", "cache that vanishes midway",   "cache that is truncated midway"};

std::vector<StabilityCase> allCases() {
  std::vector<StabilityCase> all;
  for (const auto& cases :
       {sampledFunctionCases(), wallCases(),                                                      // functions
        singularJacobianCases(), extremeFitCases(), hopelessStartCases(), singularMatrixCases(),  // optimisers
        pcaCases(),                                                                               // pca
        generatorPrecisionCases(), heldOutFamilyCases(),                                          // generator
        sceneSizeCases(), strangeTriangleCases(), triangleCountCases()}) {                        // scenes
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

Json caseJson(const std::string& group, const std::string& name, const std::string& must_hold, const StabilityResult& result,
              bool ran) {
  Json figures = Json::object();
  // JSON knows no infinity: null says that a figure was not finite
  for (const auto& [key, value] : result.figures) figures[key] = std::isfinite(value) ? Json(value) : Json(nullptr);
  return {{"group", group},
          {"name", name},
          {"must_hold", must_hold},
          {"measured", result.measured},
          {"figures", figures},
          {"holds", result.holds},
          {"fails_check", result.fails_check},
          {"ran", ran},
          {"note", result.note}};
}

// A remark that a case makes whatever comes out explains no failure: beside what was measured it may stand, as the note of a case
// that fails it would excuse it.
StabilityResult withoutExcuse(StabilityResult result) {
  if (result.holds || result.note.empty()) return result;
  result.measured += " (" + result.note + ")";
  result.note.clear();
  return result;
}

StabilityResult notRun(const std::string& why) { return {.measured = "not run", .note = "not run: " + why}; }

StabilityResult measure(const StabilityCase& stability_case, const StabilityInputs& inputs) {
  try {
    return withoutExcuse(stability_case.measure(inputs));
  } catch (const std::bad_alloc&) {
    throw;  // says something of the machine, and nothing of the case
  } catch (const std::exception& error) {
    return {.measured = std::string("ended with an exception: ") + error.what()};
  }
}

// Why a case is not run; empty when it is.
std::string reasonToSkip(const StabilityCase& stability_case, const StabilityInputs& inputs) {
  if (stability_case.needs_generators && inputs.generators.empty()) return "it needs --weights";
  if (stability_case.depth <= inputs.depth) return "";
  return stability_case.depth == StabilityDepth::lengthy ? "it needs --long" : "left out by --short";
}

void addTrainingCase(const Json& entry, StabilityReport* report) {
  const StabilityResult result = withoutExcuse({.holds = entry.at("holds").get<bool>(),
                                                .measured = entry.at("measured").get<std::string>(),
                                                .note = entry.at("note").get<std::string>()});
  report->cases.push_back({{"group", "training"},
                           {"name", entry.at("name")},
                           {"must_hold", entry.at("must_hold")},
                           {"measured", result.measured},
                           {"figures", entry.at("figures")},
                           {"holds", result.holds},
                           {"fails_check", false},
                           {"ran", true},
                           {"note", result.note}});
  if (result.holds) {
    ++report->passed;
  } else {
    report->failed.push_back("training: " + entry.at("name").get<std::string>());
  }
}

void addTraining(const StabilityRequest& request, StabilityReport* report) {
  std::set<std::string> found;
  if (!request.training.empty()) {
    try {
      const Json file = Json::parse(readFile(request.training));
      for (const Json& entry : file.at("cases")) {
        addTrainingCase(entry, report);
        found.insert(entry.at("name").get<std::string>());
      }
    } catch (const nlohmann::json::exception& error) {
      throw InputError(request.training, "JSON", "the file of training_cases.py", error.what());
    }
  }
  for (const char* name : kTrainingCases) {
    if (found.count(name) > 0) continue;
    const std::string why =
        request.training.empty() ? "it needs --training, the file of training_cases.py" : "the file of --training lacks it";
    report->cases.push_back(
        caseJson("training", name, "training stops with the cause or goes on from the last good state", notRun(why), false));
    ++report->not_run;
  }
}

}  // namespace

StabilityReport runStability(const StabilityRequest& request) {
  if (!request.only.empty() && std::find(kGroups.begin(), kGroups.end(), request.only) == kGroups.end()) {
    throw UsageError("--only", fmt::format("one of {}", fmt::join(kGroups, ", ")), "'" + request.only + "'");
  }
  StabilityInputs inputs;
  inputs.depth = request.depth;
  OneFileEach given("--weights", "representation");
  for (const std::string& path : request.weights) {
    Generator generator = loadGenerator(path);
    const std::string name = representationName(generator.representation());
    inputs.generators.push_back({name, std::move(generator), loadGeneratorData(path)});
    given.add(path, inputs.generators.back().name);
  }

  std::vector<StabilityCase> cases = allCases();
  std::erase_if(cases, [&](const StabilityCase& c) { return !request.only.empty() && c.group != request.only; });
  StabilityReport report;
  report.cases = Json::array();
  Progress progress("cases", static_cast<int64_t>(cases.size()));
  for (size_t i = 0; i < cases.size(); ++i) {
    const StabilityCase& c = cases[i];
    progress.update(static_cast<int64_t>(i), c.group + ": " + c.name);
    const std::string reason = reasonToSkip(c, inputs);
    const StabilityResult result = reason.empty() ? measure(c, inputs) : notRun(reason);
    report.cases.push_back(caseJson(c.group, c.name, c.must_hold, result, reason.empty()));
    if (!reason.empty()) {
      ++report.not_run;
    } else if (result.holds) {
      ++report.passed;
    } else {
      report.failed.push_back(c.group + ": " + c.name);
    }
  }
  if (request.only.empty() || request.only == "training") addTraining(request, &report);
  return report;
}

}  // namespace nlg
