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

// A picture of a grid beside a truth that it was not baked for is not wrong, but seldom what was meant.
std::vector<std::string> differencesOf(const GridMetadata& metadata, const SceneSource& source, const BakeOptions& options,
                                       bool has_baselines) {
  std::vector<std::string> differences;
  if (const std::string other = otherSceneOrLight(metadata, source); !other.empty()) differences.push_back(other);
  const std::string direct = textAt(metadata, "/options/light_direct");
  if (!direct.empty() && direct != options.light_direct)
    differences.push_back("baked with light_direct " + direct + ", and drawn with " + options.light_direct);
  const auto spacing = provenanceAt(metadata, "/options/spacing_m");
  const double spacing_m = spacing.is_number() ? spacing.get<double>() : 0.0;
  if (has_baselines && spacing_m > 0.0 && static_cast<float>(spacing_m) != static_cast<float>(options.spacing_m))
    differences.push_back(
        fmt::format("baked with probes {} m apart, and the baselines' are {} m apart", spacing_m, options.spacing_m));
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
    BakedGrid baked = readLitGrid(request_.grid);
    grid_ = std::move(baked.grid);
    for (const std::string& what : differencesOf(baked.metadata, source(), options_, has_baselines)) {
      warnings_.push_back(request_.grid + ": " + what);
      std::cerr << request_.program << ": " << warnings_.back() << '\n';
    }
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
