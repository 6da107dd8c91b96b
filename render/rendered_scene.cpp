#include "render/rendered_scene.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/load_generators.h"
#include "bake/scene_bake.h"
#include "nlg/look_up.h"
#include "runtime_eval/numbers/random.h"
#include "scene/lights/light_sets.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

// Noise of neighbouring pixels must not be alike, and a receiver's must not depend on where in a picture it stands.
uint64_t seedOf(const Receiver& receiver, uint64_t seed) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  const glm::dvec3& p = receiver.position_m;
  const glm::dvec3 n(receiver.normal);
  return mixSeed(mixSeed(bits(p.x), bits(p.y), bits(p.z), seed), bits(n.x), bits(n.y), bits(n.z));
}

PositionM worldPosition(const Receiver& receiver, const glm::dvec3& origin_m) {
  const glm::dvec3 world = origin_m + receiver.position_m;
  return {world.x, world.y, world.z};
}

bool isLit(LightStatus status, const glm::vec3& irradiance) {
  return status == LightStatus::lit || status == LightStatus::faint || irradiance != glm::vec3(0.0f);
}

constexpr uint64_t kTruthStream = 0x7472757468, kBaselineStream = 0x726976616c;
constexpr std::pair<const char*, const char*> kShortNames[] = {{"ddgi", "ddgi-as-shipped"}};

// Baselines that are made together, and what their names begin with.
struct BaselineGroup {
  const char* stem;
  void (MethodSet::*add)();
};
constexpr BaselineGroup kBaselineGroups[] = {{"trilinear", &MethodSet::addTrilinear},
                                             {"valid-trilinear", &MethodSet::addTrilinear},
                                             {"exact-visibility", &MethodSet::addTrilinear},
                                             {"apv", &MethodSet::addApv},
                                             {"ddgi", &MethodSet::addDdgi}};

constexpr BaselineGroup kShippedDdgi = {"ddgi", &MethodSet::addShippedDdgi};

const BaselineGroup* groupOf(const std::string& name) {
  if (name == "ddgi" || name == "ddgi-as-shipped") return &kShippedDdgi;
  for (const BaselineGroup& group : kBaselineGroups) {
    if (name.rfind(group.stem, 0) == 0) return &group;
  }
  return nullptr;
}

bool isBaseline(const std::string& name) { return groupOf(name) != nullptr; }

LightGrid readGrid(const std::string& path, GridMetadata* metadata) {
  LightGrid grid;
  requireRead(path, readLightGridFile(path, &grid, metadata), "a light grid");
  return grid;
}

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
    warn("baked with other light than the scene has here; give the same --sky, --sun, --light-groups and --light-set");
  if (isOther(baked.light_direct, asked.light_direct))
    warn("baked with light_direct " + baked.light_direct + ", and drawn with " + asked.light_direct);
  if (has_baselines && baked.spacing_m > 0.0 && static_cast<float>(baked.spacing_m) != static_cast<float>(asked.spacing_m))
    warn(fmt::format("baked with probes {} m apart, and the baselines' are {} m apart", baked.spacing_m, asked.spacing_m));
  return differences;
}

}  // namespace

Lighting truthLighting(const LightTransport& transport, const GatherOptions& options, uint64_t seed) {
  return {"truth", [&transport, options, seed](std::span<const Receiver> receivers, ReceivedLight* received) {
            for (const Receiver& receiver : receivers) {
              const GatheredIrradiance gathered =
                  transport.gatherIrradiance(receiver.position_m, receiver.normal, options, seedOf(receiver, seed));
              *received++ = {gathered.irradiance, gathered.deviation, true};
            }
          }};
}

Lighting gridLighting(const LightGrid& grid, const glm::dvec3& origin_m) {
  return {"grid", [&grid, origin_m](std::span<const Receiver> receivers, ReceivedLight* received) {
            // of all receivers at once: what is near together is looked up together
            const size_t count = receivers.size();
            std::vector<PositionM> positions_m(count);
            std::vector<glm::vec3> normals(count), irradiance(count);
            std::vector<LightStatus> status(count);
            for (size_t i = 0; i < count; ++i) {
              positions_m[i] = worldPosition(receivers[i], origin_m);
              normals[i] = receivers[i].normal;
            }
            lookUpIrradiances(grid, positions_m.data(), &normals.data()->x, count, &irradiance.data()->x, status.data());
            for (size_t i = 0; i < count; ++i) received[i] = {irradiance[i], glm::vec3(0.0f), isLit(status[i], irradiance[i])};
          }};
}

Lighting probeShareLighting(const LightGrid& grid, const glm::dvec3& origin_m, uint32_t probe) {
  return {"weights", [&grid, origin_m, probe](std::span<const Receiver> receivers, ReceivedLight* received) {
            for (const Receiver& receiver : receivers) {
              ProbeWeights shares;
              ReceivedLight& light = *received++;
              light = {};
              lookUpShares(grid, worldPosition(receiver, origin_m), &shares);
              light.is_lit = shares.count > 0;
              for (int i = 0; i < shares.count; ++i) {
                if (shares.probe[i] == probe) light.irradiance = glm::vec3(shares.weight[i]);
              }
            }
          }};
}

Lighting measuredLighting(const std::string& name, const LightMethod& method) {
  return {name, [&method](std::span<const Receiver> receivers, ReceivedLight* received) {
            for (const Receiver& receiver : receivers) {
              const LightAnswer answer = method.irradiance_at(receiver.position_m, receiver.normal);
              const bool is_lit = answer.reach == Reach::lit || answer.reach == Reach::fallback;
              *received++ = {answer.irradiance, glm::vec3(0.0f), is_lit || answer.irradiance != glm::vec3(0.0f)};
            }
          }};
}

void checkMethodName(const std::string& place, const std::string& name) {
  if (name == "truth" || name == "grid" || isBaseline(name)) return;
  std::string stems;
  for (const BaselineGroup& group : kBaselineGroups) stems += std::string(", ") + group.stem;
  throw UsageError(place, "truth, grid" + stems + ", or one of these with :solved", "'" + name + "'");
}

std::string baselineName(const LightMethod& method) {
  std::string name;
  for (const char sign : method.weights) {
    if (std::isalnum(static_cast<unsigned char>(sign))) {
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(sign)));
    } else if (sign == ' ') {
      name += '-';
    }
  }
  return method.light == "solved" ? name + ":solved" : name;
}

RenderedScene::RenderedScene(const RenderRequest& request, const BakeOptions& options)
    : request_(request), options_(options), threads_(options.threads > 0 ? options.threads : machineThreadCount()) {
  const std::vector<std::string> names = methodNames(request);
  const bool has_baselines = std::any_of(names.begin(), names.end(), isBaseline);
  if (request.bake || has_baselines) {
    baked_scene_.emplace(request.scene, options);
  } else {
    source_ = loadLitScene(request.scene, options);
    rays_ = std::make_unique<RayScene>(source_.scene);
  }
  tellNotes(request.program, source());
  transport_ = std::make_unique<LightTransport>(scene(), baked_scene_ ? baked_scene_->rays : *rays_);
  makeGrid(has_baselines);
  if (has_baselines) makeBaselines();
}

void RenderedScene::makeGrid(bool has_baselines) {
  if (request_.bake) {
    const std::vector<std::string> weights =
        request_.weights.empty() ? shippedWeights(options_.representation, weightsFolders()) : request_.weights;
    grid_ = bakeScene(*baked_scene_, loadGenerators(weights).generators, options_, temporaryFolder()).grid;
  } else if (!request_.grid.empty()) {
    GridMetadata metadata;
    grid_ = readGrid(request_.grid, &metadata);
    const BakedAs baked = bakedAs(metadata), asked{source().id, options_.light_direct, lightSha256(source()), options_.spacing_m};
    warnings_ = differencesOf(request_.grid, baked, asked, has_baselines);
    for (const std::string& warning : warnings_) std::cerr << request_.program << ": " << warning << '\n';
  }
  if (!grid_ || !grid_->light.empty() || request_.show == "weights") return;
  if (request_.bake) throw UsageError("--light", "solved, integrated or point", "none, and a view needs light");
  throw InputError(request_.grid, "light", "a grid that was baked with light", "a grid without light");
}

void RenderedScene::makeBaselines() {
  MethodSetOptions options;
  options.solve = probeLightOptions(options_, baked_scene_->air.places.size());
  options.probe = options.solve.probe;
  options.thread_count = threads_;
  options.seed = mixSeed(options_.seed, kBaselineStream);
  baselines_ = std::make_unique<MethodSet>(MethodScene{*transport_, baked_scene_->tree, baked_scene_->air}, options);
  // each once, however many of its methods are asked for
  std::vector<void (MethodSet::*)()> added;
  for (const std::string& name : methodNames(request_)) {
    const BaselineGroup* group = groupOf(name);
    if (group == nullptr || std::find(added.begin(), added.end(), group->add) != added.end()) continue;
    added.push_back(group->add);
    (baselines_.get()->*group->add)();
  }
}

Lighting RenderedScene::lighting(const std::string& name) const {
  if (name == "grid") return gridLighting(*grid_, scene().origin_m);
  if (name == "truth") {
    GatherOptions options;
    options.rays = request_.truth_rays;
    options.direct = directLightFromName(options_.light_direct);
    return truthLighting(*transport_, options, mixSeed(options_.seed, kTruthStream));
  }
  return measuredLighting(name, baseline(name));
}

const LightMethod& RenderedScene::baseline(const std::string& name) const {
  std::string whole = name;
  for (const auto& [short_name, long_name] : kShortNames) {
    if (name == short_name) whole = long_name;
  }
  std::string known;
  for (const LightMethod& baseline : baselines_->methods()) {
    if (baselineName(baseline) == whole) return baseline;
    known += (known.empty() ? "" : ", ") + baselineName(baseline);
  }
  throw UsageError(request_.panel.empty() ? "--method" : request_.panel_flag,
                   known.empty() ? "a method that this scene has" : "truth, grid or one of " + known, "'" + name + "'");
}

}  // namespace nlg
