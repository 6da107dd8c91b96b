#include <CLI/CLI.hpp>
#include <iostream>

#include <fmt/format.h>

#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"
#include "validate/stability/stability_suite.h"

namespace nlg {
namespace {

std::string originOf(const StabilityRequest& request, const OptionTable& table, const StabilityReport& report) {
  std::map<std::string, std::string> inputs;
  for (size_t i = 0; i < request.weights.size(); ++i) inputs["weights_" + std::to_string(i)] = fileSha256(request.weights[i]);
  if (!request.training.empty()) inputs["training"] = fileSha256(request.training);
  nlohmann::ordered_json options = table.toJson();
  options["depth"] = request.depth == StabilityDepth::brief ? "short" : request.depth == StabilityDepth::full ? "full" : "long";
  options["only"] = request.only;
  const nlohmann::ordered_json json = {
      {"schema_version", 1}, {"provenance", provenance("nlg-validate stability", options, inputs)}, {"cases", report.cases}};
  return json.dump(1) + "\n";
}

void run(const StabilityRequest& request, const std::string& out, const OptionTable& table) {
  std::vector<std::string> inputs = request.weights;
  inputs.push_back(request.training);
  refuseToReplaceInputs(out, inputs);
  const StabilityReport report = runStability(request);
  writeFileAtomically(out, originOf(request, table, report));
  std::cout << fmt::format("{}: {} cases hold, {} do not, {} were not run\n", out, report.passed, report.failed.size(),
                           report.not_run);
  if (report.failed.empty()) return;
  throw CheckFailed("stability", "every case that ran to hold",
                    fmt::format("{} that do not: {}", report.failed.size(), fmt::join(report.failed, "; ")));
}

}  // namespace

int stabilityMain(int argc, char** argv) {
  CLI::App app{
      "Runs stiff and extreme cases and writes what must hold and what was measured. Exit code 6 when some case does not hold.",
      "nlg-validate stability"};
  StabilityRequest request;
  std::string out;
  bool is_short = false, is_long = false;
  OptionTable table("stability");  // it has no options of a configuration
  app.add_option("--out", out, "the table to write (.json)")->required();
  app.add_option("--weights", request.weights, "exported generators; without any the cases that need them are not run");
  app.add_option("--training", request.training, "what training_cases.py wrote: the training cases");
  app.add_option("--only", request.only, "one group: functions, optimisers, pca, generator, scenes, training");
  CLI::Option* short_flag = app.add_flag("--short", is_short, "some seconds: fewer cases, smaller ones");
  app.add_flag("--long", is_long, "minutes and gigabytes: ten million triangles, a million functions")->excludes(short_flag);
  return runTool(argc, argv, app, table, [&] {
    if (is_short) request.depth = StabilityDepth::brief;
    if (is_long) request.depth = StabilityDepth::lengthy;
    run(request, out, table);
  });
}

}  // namespace nlg
