// nlg-validate: how good exported generators are on held-out scenes, and what else can be measured of them.

#include <CLI/CLI.hpp>

#include "bake/policy_options.h"
#include "tool/command/tool_main.h"
#include "validate/commands.h"
#include "validate/generators/validation.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

int validateMain(int argc, char** argv) {
  CLI::App app{
      "Measures exported generators on held-out scenes, through the bake's own policy, against long fits.\n"
      "nlg-validate stability --out FILE: runs stiff and extreme cases.\n"
      "nlg-validate frontier: error against run time, of generators, their settings and every fit.\n"
      "nlg-validate light SCENE: error of every method's light against ground truth.\n"
      "nlg-validate views SCENE: error of every method's pictures against ground truth.",
      "nlg-validate"};
  ValidationRequest request;
  ValidateOptions options;
  OptionTable table("validate");
  describe(options, table);
  table.addNote(stagesHelp({}));
  table.common({"training", "direct_functions", "threads"});
  app.add_option("--weights", request.weights, "exported generators, one per representation")->required();
  app.add_option("--held-out", request.held_out, "shards of held-out scenes")->required();
  app.add_option("--training", request.training, "training shards; their functions are counted, and compared with held-out ones");
  app.add_option("--out", request.out_dir, "folder for summary.json, functions.csv and slices.json")->required();
  return runTool(argc, argv, app, table, [&] { validate(request, options, table); });
}

// without one it validates
constexpr Command kCommands[] = {
    {"stability", stabilityMain}, {"frontier", frontierMain}, {"light", lightMain}, {"views", viewsMain}};

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (const std::optional<int> status = nlg::runCommand(argc, argv, nlg::kCommands)) return *status;
  return nlg::validateMain(argc, argv);
}
