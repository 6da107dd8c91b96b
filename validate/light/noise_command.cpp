#include "validate/commands.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/load_generators.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "validate/generators/function_counts.h"
#include "validate/light/noise.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

struct Request {
  std::string scene, weights, out;
  int runs = 4;
};

Json noiseJson(const Noise& noise) { return {{"count", noise.count}, {"median", noise.median}, {"p95", noise.p95}}; }

void measure(const Request& request, BakeOptions options, const OptionTable& table) {
  takeThetaPrecision(&options);
  refuseToReplaceInputs(request.out, {request.scene, request.weights});
  requireOutputFile(request.out);
  const std::vector<Generator> generators = loadGenerators({request.weights}).generators;
  const PreparedScene scene(request.scene, options);
  tellNotes("nlg-validate", scene.source);
  // functions are baked once, without light: noise is of the light alone
  BakeOptions unlit = options;
  unlit.light = "none";
  const Bake bake = bakeScene(scene, generators, unlit, temporaryFolder());
  const NoiseFigures figures = measureNoise(scene, options, bake.grid, request.runs);
  // provenance, by digests of what was read
  std::map<std::string, std::string> hashes = {{"weights", fileSha256(request.weights)}};
  if (!scene.source.sha256.empty()) hashes["scene"] = scene.source.sha256;
  const Json json = {{"schema_version", 1},
                     {"provenance", provenance("nlg-validate light-noise", table.toJson(), hashes)},
                     {"scene", scene.source.id},
                     {"light", options.light},
                     {"spacing_m", options.spacing_m},
                     {"runs", request.runs},
                     {"noise", noiseJson(figures.probes)},
                     {"answers", noiseJson(figures.answers)},
                     {"probes_per_s", figures.probes_per_s},
                     {"measure_share", figures.measure_share}};
  writeFileAtomically(request.out, json.dump(1) + "\n");
  std::cout << json.dump() << '\n';
}

}  // namespace

int lightNoiseMain(int argc, char** argv) {
  CLI::App app{
      "Bakes one level and lights its probes several times on one thread with different seeds: measures the noise of probe "
      "light\n"
      "and the probes lit per second. Settings of the bake: section bake of the configuration.",
      "nlg-validate light-noise"};
  Request request;
  BakeOptions options;
  OptionTable table("bake");
  describe(options, table);
  table.common({"spacing_m", "light_rays", "runs"});
  app.add_option("scene", request.scene, "scene, as for nlg-bake")->required();
  app.add_option("--weights", request.weights, "exported generator")->required();
  app.add_option("--out", request.out, "result to write (.json)")->required();
  table.flagsAlone();
  table.add("runs", &request.runs, "number of bakes of the light", 2, 1000);
  return runTool(argc, argv, app, table, [&] { measure(request, options, table); });
}

}  // namespace nlg
