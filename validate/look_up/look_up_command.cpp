#include "validate/look_up/look_up_command.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/load_generators.h"
#include "bake/scene_bake.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"
#include "validate/look_up/look_up_error.h"
#include "validate/look_up/specks.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kPlaceStream = 0x706c6163, kJumpStream = 0x6a756d70, kSpeckStream = 0x737065636b;  // of the seed

struct Request {
  std::string scene, out;
  std::vector<std::string> weights;
  PlaceOptions places;
  uint64_t specks = 0;  // places in air that are searched for them
};

Json figuresJson(const LookUpFigures& f) {
  return {{"places", f.places},
          {"unlit", f.unlit},
          {"rmse", f.rmse},
          {"wrong", {{"mean", f.wrong_mean}, {"p99", f.wrong_p99}}},
          {"wrong_to_seen", f.wrong_to_seen},
          {"leak", {{"mean", f.leak_mean}, {"p99", f.leak_p99}}}};
}

Json byDistanceJson(const LookUpFiguresByDistance& figures) {
  Json json = {{"all", figuresJson(figures.all)}, {"by_distance", Json::array()}};
  for (const LookUpFigures& f : figures.by_class) json["by_distance"].push_back(figuresJson(f));
  return json;
}

Json jumpsJson(const JumpFigures& f) {
  return {{"segments", f.segments}, {"hanging", f.hanging}, {"mean", f.mean}, {"p99", f.p99}, {"largest", f.largest}};
}

Json specksJson(const Specks& specks, const glm::dvec3& origin_m) {
  Json json = {{"looked_up", specks.looked_up}, {"count", specks.count}, {"first", Json::array()}};
  for (const Speck& speck : specks.first) {
    const glm::dvec3 at = origin_m + speck.position_m;
    json["first"].push_back({{"position_m", {at.x, at.y, at.z}}, {"share", speck.largest_share}, {"seen_by", speck.seen_by}});
  }
  return json;
}

double share(uint64_t count, uint64_t of) { return of > 0 ? static_cast<double>(count) / static_cast<double>(of) : 0.0; }

// figures   of any blends at these places: what target φ and visibility leave unlit is the same for all
Json placesJson(const Places& places, const LookUpFiguresByDistance& figures) {
  Json json = {{"drawn", places.drawn},
               {"in_solid", share(places.in_solid, places.drawn)},
               {"disputed", share(places.disputed, places.drawn)},
               {"in_air", share(places.in_air, places.drawn)},
               {"outside", share(places.outside, places.in_air)},
               {"unlit_by_target", figures.all.unlit_target},
               {"seen_by_no_probe", figures.all.seen_by_none},
               {"by_distance", Json::array()}};
  for (size_t c = 0; c < kDistanceClassCount; ++c) {
    json["by_distance"].push_back({{"from_m", c > 0 ? kDistanceBordersM[c - 1] : 0.0},
                                   {"to_m", c < kDistanceBordersM.size() ? Json(kDistanceBordersM[c]) : Json()},
                                   {"air_share", places.air_share[c]},
                                   {"places", places.kept[c]},
                                   {"unlit_by_target", figures.by_class[c].unlit_target},
                                   {"seen_by_no_probe", figures.by_class[c].seen_by_none}});
  }
  return json;
}

// Where places are drawn: what the bake covers, in the scene's coordinates.
ExtentBox drawnExtent(const Scene& scene, const BakeOptions& options) {
  if (const auto extent = extentFromNumbers(options.extent_m))
    return {extent->low_m - scene.origin_m, extent->high_m - scene.origin_m};
  const Bounds bounds = sceneBounds(scene);
  return {glm::dvec3(bounds.min), glm::dvec3(bounds.max)};
}

class LookUpMeasurement {
 public:
  LookUpMeasurement(const BakeScene& scene, const BakeOptions& options, const PlaceOptions& place_options)
      : scene_(scene),
        options_(options),
        places_(drawPlaces(drawnExtent(scene.source.scene, options), scene.rays, SupportVisibility(scene.rays, scene.links),
                           scene.tree, place_options)),
        truth_(trueWeights(places_.positions(), scene.tree, scene.rays, scene.links, options.diffusion,
                           options.threads > 0 ? options.threads : machineThreadCount())) {}

  const Places& places() const { return places_; }

  // As many draws as have this many places in air among them.
  Specks specks(const LightGrid& grid, uint64_t in_air) const {
    SpeckOptions specks;
    const double air_share = share(places_.in_air, places_.drawn);
    specks.places = air_share > 0.0 ? static_cast<uint64_t>(static_cast<double>(in_air) / air_share) : 0;
    specks.seed = mixSeed(options_.seed, kSpeckStream);
    specks.threads = options_.threads > 0 ? options_.threads : machineThreadCount();
    const Scene& scene = scene_.source.scene;
    return findSpecks(grid, scene_.tree, scene.origin_m, scene_.rays, drawnExtent(scene, options_), specks);
  }

  LookUpFiguresByDistance target() const { return figuresOf(targetBlends(truth_), places_, truth_); }

  Json measure(const LookUp& look_up) const {
    Json json = byDistanceJson(figuresOf(blendsOf(look_up, places_.places, truth_), places_, truth_));
    json["jumps"] =
        jumpsJson(measureJumps(places_.places, scene_.tree, scene_.rays, look_up, mixSeed(options_.seed, kJumpStream)));
    return json;
  }

 private:
  const BakeScene& scene_;
  const BakeOptions& options_;
  Places places_;
  std::vector<TrueWeights> truth_;
};

void measureLookUps(Request request, BakeOptions options, const OptionTable& table) {
  takeThetaPrecision(&options);
  std::vector<std::string> inputs = request.weights;
  inputs.push_back(request.scene);
  refuseToReplaceInputs(request.out, inputs);
  requireOutputFile(request.out);
  const auto [generators, paths] = loadGenerators(request.weights);
  const BakeScene scene(request.scene, options);
  tellNotes("nlg-validate", scene.source);
  request.places.seed = mixSeed(options.seed, kPlaceStream);
  const LookUpMeasurement measurement(scene, options, request.places);
  const glm::dvec3& origin_m = scene.source.scene.origin_m;

  Json used = table.toJson();
  used.erase("threads");
  used.erase("representation");
  used["places"] = request.places.places;
  used["specks"] = request.specks;
  std::map<std::string, std::string> hashes;
  if (!scene.source.sha256.empty()) hashes["scene"] = scene.source.sha256;
  for (size_t i = 0; i < generators.size(); ++i)
    hashes["weights of " + std::string(representationName(generators[i].representation()))] = fileSha256(paths[i]);
  Json json = {{"schema_version", 1},
               {"provenance", provenance("nlg-validate look-up", used, hashes)},
               {"scene", scene.source.id},
               {"spacing_m", options.spacing_m}};
  const LookUpFiguresByDistance target = measurement.target();
  json["places"] = placesJson(measurement.places(), target);
  json["target"] = byDistanceJson(target);
  for (const Generator& generator : generators) {
    const Bake bake = bakeScene(scene, {generator}, options, temporaryFolder());
    if (!json.contains("tent")) {
      LightGrid tents = bake.grid;
      for (uint32_t& function : tents.probe_function) function = function == kNoWeight ? kNoWeight : kFreeSpace;
      json["tent"] = measurement.measure(lookUpOf(tents, origin_m));
    }
    Json figures = measurement.measure(lookUpOf(bake.grid, origin_m));
    const BorderFigures border = measureBorder(bake.grid);
    figures["border"] = {
        {"functions", border.functions}, {"mean", border.mean}, {"p99", border.p99}, {"largest", border.largest}};
    if (request.specks > 0) figures["specks"] = specksJson(measurement.specks(bake.grid, request.specks), origin_m);
    json["representations"][representationName(generator.representation())] = figures;
  }
  writeFileAtomically(request.out, json.dump(1) + "\n");
  std::cout << request.out << '\n';
}

}  // namespace

int lookUpMain(int argc, char** argv) {
  CLI::App app{
      "Bakes one level with each of the given weights and measures the weights that look-ups blend, at random places in air,\n"
      "against target functions at the very same places. Settings of the bake: section bake of the configuration.",
      "nlg-validate look-up"};
  Request request;
  BakeOptions options;
  OptionTable table("bake");
  describe(options, table);
  table.common({"spacing_m", "threads", "places"});
  app.add_option("scene", request.scene, "a scene, as nlg-bake takes it")->required();
  app.add_option("--weights", request.weights, "exported generators, one a representation; each makes a bake of its own")
      ->required();
  app.add_option("--out", request.out, "the result (.json)")->required();
  app.add_option("--places", request.places.places, "places in air, a quarter of them in each class of distance to a surface")
      ->check(CLI::Range(4, 10000000))
      ->capture_default_str();
  app.add_option(
         "--specks", request.specks,
         "places in air that are searched for specks: lit, though no probe that sees them has a twentieth of its tent there. "
         "0: none are searched")
      ->check(CLI::Range(0, 1000000000))
      ->capture_default_str();
  return runTool(argc, argv, app, table, [&] { measureLookUps(request, options, table); });
}

}  // namespace nlg
