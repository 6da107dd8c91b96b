// nlg-bake: one scene and trained generators → a light grid of weighting functions.

#include <cstring>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "bake/again/bake_provenance.h"
#include "bake/bake_command.h"
#include "bake/policy_options.h"
#include "bake/probe_list.h"
#include "nlg/simd.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"

namespace nlg {
namespace {

void chooseSimd(const std::string& name) {
  // the variable first, whatever the option says: later Generator::load would read it and override the option
  const SimdStatus inherited = forceSimdTargetFromEnvironment();
  if (inherited != SimdStatus::ok) {
    const char* variable = std::getenv("NLG_SIMD");
    throw UsageError("NLG_SIMD", "a SIMD target of this machine", simdRefusal(variable ? variable : "", inherited));
  }
  if (name.empty()) return;
  const SimdStatus status = forceSimdTarget(name);
  if (status != SimdStatus::ok) throw UsageError("--simd", "a SIMD target of this machine", simdRefusal(name, status));
}

nlohmann::ordered_json describeFile(const std::string& path) {
  auto [grid, metadata] = readBakedGrid(path);
  nlohmann::ordered_json json = {{"scene", metadata["scene"]},
                                 {"probes", grid.tree.probeCount()},
                                 {"cells", grid.tree.cellCount()},
                                 {"spacing_m", bakedSpacing(grid, metadata)},
                                 {"functions", grid.functionCount()},
                                 {"has_light", !grid.light.empty()},
                                 {"light_axes", grid.packed_light.axes.size()},
                                 {"light_bytes", grid.light.empty() ? 0 : packedLightBytes(grid)}};
  for (const LightGroup& group : grid.groups) {
    json["light_groups"].push_back(group.name);
    if (group.begins_dark) json["light_groups_dark"].push_back(group.name);
  }
  for (const Representation& representation : grid.representations)
    json["representations"].push_back(representationName(representation));
  json["verified"] = kVerifiedByDigest;
  json["origin"] = parsedOrText(metadata["provenance"]);
  return json;
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "info") == 0)
    return nlg::fileInfoMain(argc - 1, argv + 1, {"nlg-bake info", "light grids (.safetensors)", "bake", nlg::describeFile});
  if (argc > 1 && std::strcmp(argv[1], "probes") == 0) return nlg::probeListMain(argc - 1, argv + 1);
  CLI::App app{
      "Bakes one scene into a light grid: places probes, computes their weighting functions, and lights them.\n"
      "nlg-bake SCENE: with the supplied weights.\n"
      "nlg-bake SCENE --weights W1 [W2 ...] --out GRID: with your own weights; the scene comes first, because --weights takes "
      "several files.\n"
      "nlg-bake SCENE --relight GRID: computes only the light of a baked grid again.\n"
      "nlg-bake SCENE --check GRID: whether a grid is up to date.\n"
      "nlg-bake info GRID ...: verifies and describes light grids.\n"
      "nlg-bake probes GRID: prints the probes of a grid as a table.",
      "nlg-bake"};
  nlg::BakeRequest request;
  nlg::BakeOptions options;
  options.spacing_m = 0.0;  // chosen by the scene
  nlg::OptionTable table("bake");
  nlg::describe(options, table);
  table.addNote(nlg::stagesHelp({}));
  table.common({"unit", "spacing_m", "extent_m", "sky", "sun", "light_unit", "intensity", "light_direct", "out"});
  app.add_option("scene", request.scene, nlg::sceneForms())->required();
  app.add_option("--weights", request.weights,
                 "weights of nlg-export. With several the bake chooses a representation for every function. None: the supplied "
                 "weights, in the folder $NLG_WEIGHTS or beside the installed program");
  const CLI::Option* out =
      app.add_option("--out", request.out, "light grid to write. None: SCENE.safetensors in the current folder");
  app.add_option("--relight", request.relit,
                 "light grid of this scene, baked with the same settings: its probes and functions are reused, and only light is "
                 "computed again");
  app.add_option("--check", request.checked,
                 "light grid to compare with what this command would bake; nothing is baked. Exit code 6 if it is out of date, "
                 "with what has changed");
  app.add_option("--json", request.json,
                 "file for the report of the bake or of --check, as one line of JSON. -: standard output");
  app.add_option("--collect", request.collect,
                 "folder for SCENE.collected.h5, a shard of the functions that fail the check, for training (scenes.collected)");
  app.add_option("--inputs", request.inputs,
                 "file for the names of all files and folders that the bake reads or looks for, as a JSON list for build "
                 "systems, also after an error. Light grids and programs are not listed");
  return nlg::runTool(argc, argv, app, table, [&] {
    const CLI::Option* config = app.get_option("--config");
    request.out_is_given = out->count() > 0;
    if (config->count() > 0) request.config = config->as<std::string>();
    nlg::takeThetaPrecision(&options);
    nlg::chooseSimd(options.simd);
    nlg::runBakeCommand(request, options, table);
  });
}
