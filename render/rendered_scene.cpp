#include "render/rendered_scene.h"

#include <algorithm>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/load_generators.h"
#include "bake/scene_bake.h"
#include "nlg/look_up.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kTruthStream = 0x7472757468, kBaselineStream = 0x726976616c;

// What a grid's light depends on, of the settings that a view is asked for with.
struct BakedAs {
  std::string scene, light_direct, light_of_scene;
  double spacing_m = 0.0;
};

// Of a grid that says nothing of its making everything is empty.
BakedAs bakedAs(const GridMetadata& metadata) {
  using Json = nlohmann::json;
  const auto textOf = [&](const char* key) { return metadata.contains(key) ? metadata.at(key) : std::string(); };
  const Json provenance = Json::parse(textOf("provenance"), nullptr, false);
  // null where there is no such place
  const auto at = [&](const char* place) {
    const Json::json_pointer pointer(place);
    return provenance.contains(pointer) ? provenance[pointer] : Json();
  };
  const auto text = [](const Json& value) { return value.is_string() ? value.get<std::string>() : std::string(); };
  const Json spacing = at("/options/spacing_m");
  return {textOf("scene"), text(at("/options/light_direct")), text(at((std::string("/inputs/") + kLightRole).c_str())),
          spacing.is_number() ? spacing.get<double>() : 0.0};
}

// A picture of a grid beside a truth that it was not baked for is not wrong, but seldom what was meant.
std::vector<std::string> differencesOf(const std::string& path, const BakedAs& baked, const BakedAs& asked, bool has_baselines) {
  std::vector<std::string> differences;
  const auto warn = [&](const std::string& what) { differences.push_back(path + ": " + what); };
  const auto isOther = [](const std::string& a, const std::string& b) { return !a.empty() && a != b; };
  if (isOther(baked.scene, asked.scene)) warn("baked from " + baked.scene + ", and drawn in " + asked.scene);
  if (isOther(baked.light_of_scene, asked.light_of_scene))
    warn("baked with other light than the scene has here; give the same --sky, --sun, --light-groups and --light-state");
  if (isOther(baked.light_direct, asked.light_direct))
    warn("baked with light_direct " + baked.light_direct + ", and drawn with " + asked.light_direct);
  if (has_baselines && baked.spacing_m > 0.0 && static_cast<float>(baked.spacing_m) != static_cast<float>(asked.spacing_m))
    warn(fmt::format("baked with probes {} m apart, and the baselines' are {} m apart", baked.spacing_m, asked.spacing_m));
  return differences;
}

}  // namespace

std::string baselineNames() {
  std::string names;
  for (const MethodSet::Baseline& baseline : MethodSet::baselines())
    names += std::string(names.empty() ? "" : ", ") + baseline.name;
  return names;
}

void checkMethodName(const std::string& place, const std::string& name) {
  if (name == "truth" || name == "grid" || MethodSet::isBaseline(name)) return;
  throw UsageError(place, "truth, grid, " + baselineNames() + ", or one of these with :solved", "'" + name + "'");
}

LightGrid readGrid(const std::string& path, GridMetadata* metadata) {
  LightGrid grid;
  requireRead(path, readLightGridFile(path, &grid, metadata), "a light grid");
  if (grid.light.empty()) throw InputError(path, "light", "a grid that was baked with light", "a grid without light");
  return grid;
}

RenderedScene::RenderedScene(const RenderRequest& request, const BakeOptions& options)
    : request_(request), options_(options), threads_(options.threads > 0 ? options.threads : machineThreadCount()) {
  // before anything is baked
  if (request.bake && options.light == "none")
    throw UsageError("--light", "solved, integrated or point", "none, and a view needs light");
  const std::vector<std::string> names = methodNames(request);
  const bool has_baselines = std::any_of(names.begin(), names.end(), MethodSet::isBaseline);
  if (request.bake || has_baselines) {
    baked_scene_.emplace(request.scene, options);
  } else {
    source_ = loadLitScene(request.scene, options);
    rays_ = std::make_unique<RayScene>(source_.scene);
  }
  tellNotes(request.program, source());
  if (request.bake) tellLightNotes(source());
  transport_ = std::make_unique<LightTransport>(scene(), baked_scene_ ? baked_scene_->rays : *rays_);
  makeGrid(has_baselines);
}

void RenderedScene::makeGrid(bool has_baselines) {
  if (request_.bake) {
    const std::vector<std::string> weights =
        request_.weights.empty() ? shippedWeights(options_.representation, weightsFolders()) : request_.weights;
    grid_ = bakeScene(*baked_scene_, loadGenerators(weights).generators, options_, temporaryFolder()).grid;
  } else if (!request_.grid.empty()) {
    GridMetadata metadata;
    grid_ = readGrid(request_.grid, &metadata);
    const BakedAs baked = bakedAs(metadata),
                  asked{source().id, options_.light_direct, sceneLightSha256(scene()), options_.spacing_m};
    warnings_ = differencesOf(request_.grid, baked, asked, has_baselines);
    for (const std::string& warning : warnings_) std::cerr << request_.program << ": " << warning << '\n';
  }
}

const MethodSet& RenderedScene::baselines() const {
  if (baselines_) return *baselines_;
  MethodSetOptions options;
  options.solve = probeLightOptions(options_, baked_scene_->air.places.size());
  options.probe = options.solve.probe;
  options.thread_count = threads_;
  options.seed = mixSeed(options_.seed, kBaselineStream);
  baselines_ = std::make_unique<MethodSet>(MethodScene{*transport_, baked_scene_->tree, baked_scene_->air}, options);
  for (const std::string& name : methodNames(request_)) baselines_->addNamed(name);
  return *baselines_;
}

LightAt RenderedScene::light(const std::string& name) const {
  if (name == "grid") return gridLight(*grid_, scene().origin_m);
  if (name != "truth") return baseline(name).light_at;
  GatherOptions options;
  options.rays = request_.truth_rays;
  options.direct = directLightFromName(options_.light_direct);
  return trueLight(*transport_, options, mixSeed(options_.seed, kTruthStream));
}

const LightMethod& RenderedScene::baseline(const std::string& name) const {
  if (const LightMethod* method = baselines().named(name)) return *method;
  std::string known = "truth, grid";
  for (const LightMethod& method : baselines().methods()) known += " or " + MethodSet::commandName(method);
  throw UsageError(request_.panel.empty() ? "--method" : request_.panel_flag, known, "'" + name + "'");
}

}  // namespace nlg
