#include "validate/commands.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/scene_bake.h"
#include "light/air.h"
#include "light/methods/method_set.h"
#include "render/picture/image.h"
#include "render/place_picture.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "train/torch_threads.h"
#include "validate/generators/function_counts.h"
#include "validate/generators/summary_json.h"
#include "validate/light/asked_bakes.h"
#include "validate/light/light_figures.h"
#include "validate/light/neural/learned_methods.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kPlaceStream = 0x706c6163, kTruthStream = 0x7472757468, kFloorStream = 0x666c6f6f72,
                   kPictureStream = 0x70696374, kLearnedStream = 0x6c6561726e;

struct Request {
  std::string scene, out;
  std::vector<double> spacings_m;
  std::vector<double> grid_spacings_m;  // more of them, of grids alone
  std::vector<double> thin_errors;
  std::vector<std::string> weights;  // each a bake: one file, or several with commas between them, of which the bake chooses
  int air_samples = 2000, surface_samples = 1600, walks = 40, edge_samples = 400;
  LightPlaceOptions places;  // these numbers from those above
  GatherOptions truth{1024, 64}, probe{1024, 64};
  bool grids_only = false;  // no baselines: a fraction of the time
  bool neural = false;      // methods that learn, too
  int neural_samples = 4, neural_steps = 3000;
  std::string pictures;  // the folder for pictures of worst places; empty: none are drawn
  int picture_rays = 64;
};

// On figures.
const std::vector<std::string> kWithoutEffect = {"threads", "representation", "picture_rays"};

double finestSpacing(const Request& request) { return *std::min_element(request.spacings_m.begin(), request.spacings_m.end()); }

LightPlaces placesInRooms(const PreparedScene& scene, const std::vector<std::string>& extent_m, const LightPlaceOptions& options,
                          int threads) {
  LightPlaces places = drawLightPlaces(scene.source.scene, scene.rays, lightExtent(scene.source.scene, extent_m), options);
  partIntoRooms(&places, scene.rays, threads);
  return places;
}

const std::vector<size_t> kOctreeKilobytes = {32, 64, 128, 256, 512, 1024, 2048};

// Eight probes' harmonics, blended and then turned to the normal.
LearnedCost octreeCost(const LightMethod& octree, size_t places) {
  LearnedCost cost;
  cost.parameters = octree.probes * kShFloats;
  cost.multiply_adds = 8 * kShFloats + kShFloats;
  cost.words_by_place = 8 * kShFloats;  // floats, as a look-up finds them in memory; the file's bytes are coded
  cost.places = places;
  return cost;
}

Json learnedJson(const LearnedCost& cost) {
  return {{"places", cost.places},
          {"networks", cost.networks},
          {"steps", cost.steps},
          {"parameters", cost.parameters},
          {"clamped", cost.clamped},
          {"multiply_adds", cost.multiply_adds},
          {"words", {{"by_place", cost.words_by_place}, {"shared", cost.words_shared}}}};
}

class LightMeasurement {
 public:
  LightMeasurement(const Request& request, const BakeOptions& options, const PreparedScene& scene)
      : request_(request),
        options_(options),
        threads_(options.threads > 0 ? options.threads : machineThreadCount()),
        transport_(scene.source.scene, scene.rays),
        places_(placesInRooms(scene, options.extent_m, request.places, threads_)),
        truth_(lightTruth(places_, transport_, {request.truth, mixSeed(options.seed, kTruthStream), threads_})),
        origin_m_(scene.source.scene.origin_m),
        scene_id_(scene.source.id) {}

  const LightPlaces& places() const { return places_; }
  const LightTruth& truth() const { return truth_; }
  bool isBaked() const { return transport_.isBaked(); }

  // Harmonics gathered at the place itself: what is left is what they cannot hold.
  Json floorFigures() const {
    LightMethod method;
    method.weights = "harmonics at the point";
    method.light = "point";
    method.light_at = [&](std::span<const Receiver> receivers, LightAnswer* answers) {
      for (const Receiver& at : receivers) {
        const GatheredLight light = transport_.gather(at.position_m, request_.probe, mixSeed(options_.seed, kFloorStream));
        *answers++ = {flooredIrradiance(light.light, at.normal), Reach::lit};
      }
    };
    return measured(method);
  }

  // scene       as it is at this spacing
  // is_finest   pictures of the worst places of every grid whose light is solved for, and methods that learn, where they are asked for
  Json spacingFigures(const PreparedScene& scene, const BakeOptions& options, const GeneratorSets& sets, bool grids_alone,
                      bool is_finest) const {
    const LightTransport transport(scene.source.scene, scene.rays);
    MethodSetOptions method_options = methodSetOptions(options, request_.probe, scene.air.places.size(), threads_);
    if (!request_.thin_errors.empty()) method_options.thin_errors = request_.thin_errors;
    MethodSet methods({transport, scene.tree, scene.air}, method_options);
    for (const MethodSet::Baseline& baseline : MethodSet::baselines()) {
      if (!grids_alone && !request_.grids_only) (methods.*baseline.add)(MethodSet::kGatheredAndSolved);
    }
    std::vector<glm::dvec3> positions_m;
    for (const LightPlace& place : places_.places) positions_m.push_back(place.position_m);
    if (!grids_alone) methods.addTargetFunctions(positions_m, options.diffusion);
    Json blends = Json::array();
    for (const auto& [name, generators] : sets) {
      BakeOptions without_light = options;
      without_light.light = "none";
      const double start = processorSeconds();
      Bake bake = bakeScene(scene, generators, without_light, temporaryFolder());
      blends.push_back({{"weights", name}});
      blends.back().update(toJson(bake.statistics.blend));
      methods.addGrid(name, std::move(bake.grid), processorSeconds() - start);
    }
    Json json = {{"spacing_m", options.spacing_m},
                 {"probes", {{"count", methods.probes().count()}, {"in_air", methods.probes().air_count}}},
                 {"blends", blends},
                 {"methods", Json::array()}};
    for (const LightMethod& method : methods.methods()) {
      const bool is_grid = std::any_of(sets.begin(), sets.end(), [&](const auto& set) { return set.first == method.weights; });
      json["methods"].push_back(measured(method, is_finest && is_grid && method.light == "solved"));
    }
    if (is_finest && request_.neural) addLearned({transport, scene.tree, scene.air}, options, &methods, &json["methods"]);
    return json;
  }

 private:
  // Baselines that learn from more places than the bake has.
  void addLearned(const MethodScene& scene, const BakeOptions& options, MethodSet* methods, Json* json) const {
    const ProbeLightOptions solve = methodSetOptions(options, request_.probe, scene.air.places.size(), threads_).solve;
    const LitPlaces lit =
        drawLitPlaces(scene.transport, scene.tree, scene.air, methods->placeLight(), solve, request_.neural_samples, threads_);
    const double measure_s = methods->measure_s() + lit.measure_s;
    const size_t first = methods->methods().size();
    methods->addShOctrees(lit.position_m, lit.light, kOctreeKilobytes);
    for (size_t m = first; m < methods->methods().size(); ++m) {
      json->push_back(measured(methods->methods()[m]));
      json->back()["learned"] = learnedJson(octreeCost(methods->methods()[m], lit.light.size()));
      json->back()["times"]["light_s"] = measure_s + methods->methods()[m].light_s;
    }
    for (const LearnedMethod& learned :
         learnedMethods(lit, {request_.neural_steps, threads_, mixSeed(options.seed, kLearnedStream)})) {
      json->push_back(measured(learned.method));
      json->back()["learned"] = learnedJson(learned.cost);
      json->back()["times"]["light_s"] = measure_s + learned.method.light_s;
      json->back()["times"]["training_s"] = learned.cost.training_s;
    }
  }

  Json measured(const LightMethod& method, bool may_be_drawn = false) const {
    const std::vector<LightAnswer> answers = answersAt(method.light_at, receiversAt(places_), threads_);
    const LightFigures figures = lightFigures(places_, truth_, answers);
    Json json = methodJson(method, figures, places_, truth_, answers, origin_m_);
    if (may_be_drawn && !request_.pictures.empty()) {
      for (size_t i = 0; i < figures.worst.size(); ++i)
        json["worst"][i]["picture"] = drawWorst(method, figures.worst[i], answers[figures.worst[i].place], i + 1);
    }
    return json;
  }

  // Returns the picture's path as the result names it: from the result's own folder.
  std::string drawWorst(const LightMethod& method, const WorstPlace& worst, const LightAnswer& answer, size_t rank) const {
    const LightPlace& place = places_.places[worst.place];
    const MeasuredPlace measured = {
        method.weights, {place.position_m, place.normal}, truth_.at[worst.place].irradiance, answer.irradiance, worst.error,
        truth_.rms};
    PlacePictureOptions picture;
    picture.truth_rays = request_.picture_rays;
    picture.thread_count = threads_;
    picture.seed = mixSeed(options_.seed, kPictureStream);
    const Image image = drawPlace(transport_, measured, method.light_at, picture);
    const std::string name = fmt::format("{}_{}_{:02}", fileWord(scene_id_), fileWord(method.weights), rank);
    return writePicture(image, request_.pictures, name, request_.out, "nlg-validate light");
  }

  const Request& request_;
  const BakeOptions& options_;
  const int threads_;
  LightTransport transport_;
  LightPlaces places_;
  LightTruth truth_;
  glm::dvec3 origin_m_;
  std::string scene_id_;
};

void measureLight(Request request, BakeOptions options, const OptionTable& table) {
  takeThetaPrecision(&options);
  // nothing that is read may be overwritten, and all that is written has a place
  std::vector<std::string> inputs = {request.scene};
  for (const std::string& path : weightsPaths(request.weights)) inputs.push_back(path);
  refuseToReplace(request.out, inputs, kValidationFiles);
  requireOutputFile(request.out);
  if (!request.pictures.empty()) requireOutputFolder(request.pictures);
  std::map<std::string, std::string> hashes;
  const GeneratorSets sets = loadSets(request.weights, &hashes);
  // sample points have a seed and a step of their own: the same for all spacings and methods
  if (request.spacings_m.empty()) request.spacings_m = {options.spacing_m};
  request.places.air = static_cast<uint64_t>(request.air_samples);
  request.places.surface = static_cast<uint64_t>(request.surface_samples);
  request.places.walks = static_cast<uint64_t>(request.walks);
  request.places.edges = static_cast<uint64_t>(request.edge_samples);
  request.places.seed = mixSeed(options.seed, kPlaceStream);
  request.places.step_m = finestSpacing(request) / 16.0;

  // learned methods train side by side: libtorch's own threads would only get in their way
  if (request.neural) computeOnCallingThreads();

  // truth and probes leave out the same direct light
  request.truth.direct = request.probe.direct = directLightFromName(options.light_direct);
  options.spacing_m = request.spacings_m.front();
  auto scene = std::make_unique<PreparedScene>(request.scene, options);
  tellNotes("nlg-validate", scene->source);
  if (!scene->source.sha256.empty()) hashes["scene"] = scene->source.sha256;
  const LightMeasurement measurement(request, options, *scene);
  // a large source distance may leave no place in air
  if (measurement.places().places.empty())
    throw InputError(request.scene, "air", "sample points in air at --source-distance from lamps and emissive faces", "none");
  Json json = {{"schema_version", 1},
               {"provenance", provenance("nlg-validate light", table.usedJson(kWithoutEffect), hashes)},
               {"scene", scene->source.id},
               {"truth", truthJson(measurement.places(), measurement.truth(), measurement.isBaked())}};
  json["floor"] = measurement.floorFigures();
  json["spacings"] = Json::array();
  // pictures and learned methods cost most: at the finest spacing alone
  const auto finest =
      static_cast<size_t>(std::min_element(request.spacings_m.begin(), request.spacings_m.end()) - request.spacings_m.begin());
  std::vector<std::unique_ptr<PreparedScene>> others;
  std::vector<double> spacings_m = request.spacings_m;
  spacings_m.insert(spacings_m.end(), request.grid_spacings_m.begin(), request.grid_spacings_m.end());
  // one scene a spacing, since its tree depends on it; truth is measured once
  for (size_t s = 0; s < spacings_m.size(); ++s) {
    options.spacing_m = spacings_m[s];
    if (s > 0) others.push_back(std::make_unique<PreparedScene>(request.scene, options));
    const bool grids_alone = s >= request.spacings_m.size();
    json["spacings"].push_back(
        measurement.spacingFigures(s > 0 ? *others.back() : *scene, options, sets, grids_alone, s == finest));
  }
  writeFileAtomically(request.out, json.dump(1) + "\n");
  std::cout << lightTable(json["spacings"]);
  if (!request.grids_only && !hasSheets(scene->source.scene)) std::cout << "no double-sided faces: DDGI has one rule for backs\n";
  std::cout << request.out << '\n';
}

}  // namespace

int lightMain(int argc, char** argv) {
  CLI::App app{
      "Measures the light of methods at sample points in a scene's air and before its surfaces, against ground truth: trilinear\n"
      "blends, DDGI, and the light grid with each of the given weights, with light gathered at probes and with solved light.\n"
      "Settings of the bake: section bake of the configuration.",
      "nlg-validate light"};
  Request request;
  BakeOptions options;
  OptionTable table("bake");
  describe(options, table);
  table.passedFrom("validate_light");
  table.group("Measurement");
  table.add("air_samples", &request.air_samples, "number of sample points in air", 8, 10000000);
  table.add("surface_samples", &request.surface_samples,
            "number of sample points 2 to 50 cm before surfaces, a quarter in each class of distance", 8, 10000000);
  table.add("walks", &request.walks, "number of straight walks in air, along which jumps of light are measured", 1, 100000);
  table.add("edge_samples", &request.edge_samples,
            "number of sample points under a roof within 10 cm of an edge, and as many near corners", 0, 10000000);
  table.add("truth_rays", &request.truth.rays, "rays of ground truth per sample point", 8, 1 << 24);
  table.add("probe_rays", &request.probe.rays, "rays per probe", 8, 1 << 24);
  table.add("picture_rays", &request.picture_rays,
            "rays of ground truth per pixel in pictures of the worst sample points; from 32 on, a pixel has four samples", 8,
            1 << 20);
  table.common({"weights", "spacings", "grids_only", "air_samples", "surface_samples", "truth_rays", "probe_rays", "pictures"});
  app.add_option("scene", request.scene, "scene, as for nlg-bake")->required();
  app.add_option("--out", request.out, "result to write (.json)")->required();
  app.add_option(
      "--weights", request.weights,
      "exported generators, each for a bake of its own; several joined by commas are one bake that chooses among them");
  table.flagsAlone();
  table.add("spacings", &request.spacings_m, "finest probe spacings, metres. None: spacing_m of the bake", 0.01, 1000.0);
  table.add("grid_spacings", &request.grid_spacings_m, "further finest spacings, metres, at which only grids are measured", 0.01,
            1000.0);
  table.add("thin_errors", &request.thin_errors,
            "values of thin_error, each measured as a method of its own. None: thin_error of the bake", 1e-6, kMostThinError);
  table.add("grids_only", &request.grids_only,
            "measure only grids and target functions, without baselines, in a fraction of the time");
  table.add("neural", &request.neural,
            "also measure methods that learn the scene's light, at the finest spacing; minutes for each");
  table.add("neural_samples", &request.neural_samples,
            "ratio of the sample points that these methods learn from to those of the bake", 1, 64);
  table.add("neural_steps", &request.neural_steps, "maximum training steps of each of them", 1, 1000000);
  table.add("source_distance", &request.places.source_distance_m,
            "minimum distance of sample points from lamps and emissive faces, metres; at most 1/25 of the scene's diagonal. "
            "0: no minimum",
            0.0, 1e6);
  app.add_option("--pictures", request.pictures,
                 "folder for pictures of the ten worst sample points of each of the weights, with solved light at the finest "
                 "spacing: truth, result, error. None: no pictures");
  return runTool(argc, argv, app, table, [&] { measureLight(request, options, table); });
}

}  // namespace nlg
