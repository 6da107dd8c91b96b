
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <new>

#include <fmt/format.h>

#include "bake/load_generators.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "validate/generators/summary_json.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 3> kGroups = {"functions", "codes", "generator"};

struct StabilityRequest {
  std::vector<std::string> weights;  // exported generators
  std::string only;                  // one group; empty: all
  std::string out;
  bool is_short = false;
};

struct StabilityTable {
  Json cases = Json::array();       // docs/reference/formats.md
  std::vector<std::string> failed;  // names of cases that do not hold
};

StabilityInputs readInputs(const StabilityRequest& request) {
  constexpr const char* kExpected = "a generator of this support pattern";
  StabilityInputs inputs;
  inputs.is_short = request.is_short;
  auto [generators, paths] = loadGenerators(request.weights);
  for (size_t i = 0; i < generators.size(); ++i) {
    WeightsFile file;
    GeneratorData data;
    requireRead(paths[i], readWeightsFile(paths[i], &file), kExpected);
    requireRead(paths[i], generatorFromWeights(file, &data), kExpected);
    const std::string name = representationName(data.representation);
    inputs.generators.push_back({name, std::move(generators[i]), std::move(data)});
  }
  return inputs;
}

void runCase(const StabilityCase& stability_case, const StabilityInputs& inputs, StabilityTable* table) {
  StabilityFigures figures;
  try {
    stability_case.measure(inputs, &figures);
  } catch (const std::bad_alloc&) {
    throw;  // says something of the machine, and nothing of the case
  } catch (const std::exception& error) {
    figures.require(false, std::string("ended with an exception: ") + error.what());
  }
  if (!figures.holds()) table->failed.push_back(stability_case.group + ": " + stability_case.name);
  table->cases.push_back({{"group", stability_case.group},
                          {"name", stability_case.name},
                          {"must_hold", stability_case.must_hold},
                          {"measured", figures.measured()},
                          {"figures", figures.figures()},
                          {"holds", figures.holds()},
                          {"fails_check", figures.fails_check}});
}

StabilityTable runAll(const StabilityRequest& request) {
  if (!request.only.empty() && std::find(kGroups.begin(), kGroups.end(), request.only) == kGroups.end()) {
    throw UsageError("--only", fmt::format("one of {}", fmt::join(kGroups, ", ")), "'" + request.only + "'");
  }
  const StabilityInputs inputs = readInputs(request);
  std::vector<StabilityCase> cases;
  for (const auto& group : {sampledFunctionCases(), wallCases(), codeCases(), coefficientCases()})
    cases.insert(cases.end(), group.begin(), group.end());
  const bool has_codes = std::any_of(inputs.generators.begin(), inputs.generators.end(),
                                     [](const NamedGenerator& one) { return one.generator.representation().isCode(); });
  std::erase_if(cases, [&](const StabilityCase& c) {
    return (!request.only.empty() && c.group != request.only) || (c.needs_codes && !has_codes);
  });
  if (cases.empty()) throw UsageError("--weights", "a code, for --only " + request.only, "none");
  StabilityTable table;
  Progress progress("cases", static_cast<int64_t>(cases.size()));
  for (size_t i = 0; i < cases.size(); ++i) {
    progress.update(static_cast<int64_t>(i), cases[i].group + ": " + cases[i].name);
    runCase(cases[i], inputs, &table);
  }
  return table;
}

Json originOf(const StabilityRequest& request, const OptionTable& options) {
  std::map<std::string, std::string> inputs;
  for (size_t i = 0; i < request.weights.size(); ++i) inputs["weights_" + std::to_string(i)] = fileSha256(request.weights[i]);
  Json given = options.toJson();
  given["depth"] = request.is_short ? "short" : "full";
  given["only"] = request.only;
  return provenance("nlg-validate stability", given, inputs);
}

void run(const StabilityRequest& request, const OptionTable& options) {
  refuseToReplace(request.out, request.weights, kValidationFiles);
  requireOutputFile(request.out);
  const StabilityTable table = runAll(request);
  const Json json = {{"schema_version", 1}, {"provenance", originOf(request, options)}, {"cases", table.cases}};
  writeFileAtomically(request.out, json.dump(1) + "\n");
  std::cout << fmt::format("{}: {} cases hold, {} do not\n", request.out, table.cases.size() - table.failed.size(),
                           table.failed.size());
  if (table.failed.empty()) return;
  throw CheckFailed("stability", "every case to hold",
                    fmt::format("{} that do not: {}", table.failed.size(), fmt::join(table.failed, "; ")));
}

}  // namespace

int stabilityMain(int argc, char** argv) {
  CLI::App app{"Runs stiff and extreme cases, and writes what must hold and what was measured. Exit code 6 if a case fails.",
               "nlg-validate stability"};
  StabilityRequest request;
  OptionTable table("stability");  // it has no options of a configuration
  app.add_option("--out", request.out, "table to write (.json)")->required();
  app.add_option("--weights", request.weights, "exported generators")->required();
  app.add_option("--only", request.only, fmt::format("group of cases to run: {}", fmt::join(kGroups, ", ")));
  app.add_flag("--short", request.is_short, "smaller cases: some seconds");
  return runTool(argc, argv, app, table, [&] { run(request, table); });
}

}  // namespace nlg
