#include "validate/light/closure_command.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"
#include "light/closure.h"
#include "scene/scene_source.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

struct Request {
  std::string scene, out;
  ClosureOptions closure;
};

Json rgb(const glm::dvec3& colour) { return Json::array({colour.r, colour.g, colour.b}); }

// The mean over places of what arrives from each part.
Json partMeans(const Closure& closure) {
  const std::pair<const char*, glm::vec3 ClosurePlace::*> parts[] = {
      {"baked", &ClosurePlace::baked}, {"surfaces", &ClosurePlace::surfaces}, {"emission", &ClosurePlace::emission},
      {"sky", &ClosurePlace::sky},     {"lamps", &ClosurePlace::lamps},       {"suns", &ClosurePlace::suns}};
  Json means;
  for (const auto& [name, part] : parts) {
    glm::dvec3 sum(0.0);
    for (const ClosurePlace& place : closure.places) sum += place.*part;
    means[name] = rgb(sum / static_cast<double>(std::max<size_t>(1, closure.places.size())));
  }
  return means;
}

void measure(const Request& request, const BakeOptions& options, const OptionTable& table) {
  refuseToReplaceInputs(request.out, {request.scene});
  requireOutputFile(request.out);
  if (!options.light_set.empty()) throw UsageError("--light-set", "none: one light is looked at", options.light_set.front());
  SceneSource source = loadScene(request.scene, options.reading);
  for (const std::string& done : applyLight(source.scene, options.scene_light)) source.light_notes.push_back(done);
  const Closure closure = measureClosure(source.scene, request.closure, options.seed);
  if (closure.places.empty()) throw InputError(request.scene, "light", "faces with lightmaps", "none");
  const Json json = {{"schema_version", 1},
                     {"provenance", provenance("nlg-validate light-closure", table.toJson(),
                                               {{"light of the scene", sceneLightSha256(source.scene)}})},
                     {"scene", source.id},
                     {"notes", source.light_notes},
                     {"places", closure.places.size()},
                     {"in_solid", closure.in_solid},
                     {"rays", request.closure.rays},
                     {"correlation", closure.correlation},
                     {"scale", closure.scale},
                     {"mean", partMeans(closure)}};
  writeFileAtomically(request.out, json.dump(1) + "\n");
  std::cout << json.dump() << '\n';
}

}  // namespace

int lightClosureMain(int argc, char** argv) {
  CLI::App app{
      "Predicts the light on a level's lightmapped surfaces from all that its file holds (other surfaces, what shines, sky,\n"
      "lamps, suns) and compares it with the lightmaps: their correlation, and the factor between them. Seed, sky and sun: "
      "section\n"
      "bake of the configuration.",
      "nlg-validate light-closure"};
  Request request;
  BakeOptions options;
  OptionTable table("bake");
  describe(options, table);
  table.common({"seed", "sky", "sun", "places", "rays"});
  app.add_option("scene", request.scene, "a level, as nlg-bake takes it")->required();
  app.add_option("--out", request.out, "the result (.json)")->required();
  app.add_option("--places", request.closure.places, "places before surfaces, at most")->check(CLI::Range(2, 1000000));
  app.add_option("--rays", request.closure.rays, "of every place and part")->check(CLI::Range(8, 1 << 20));
  return runTool(argc, argv, app, table, [&] { measure(request, options, table); });
}

}  // namespace nlg
