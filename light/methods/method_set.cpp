#include "light/methods/method_set.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "light/directions.h"
#include "light/methods/sh_octree.h"
#include "light/surface_cache.h"
#include "light/thinning.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr uint64_t kProbeStream = 0x70726f6265, kDdgiStream = 0x64646769, kApvStream = 0x617076, kOctreeStream = 0x6f637472;

const std::string kThinned = ", thinned ";
const std::string kDdgiAsShipped = "DDGI as shipped", kRelocated = ", relocated";
const std::string kDdgi = "ddgi", kShippedDdgi = "ddgi-as-shipped";  // on command lines

constexpr MethodSet::Baseline kBaselines[] = {{"trilinear", true, &MethodSet::addTrilinear},
                                              {"valid-trilinear", true, &MethodSet::addValidTrilinear},
                                              {"exact-visibility", false, &MethodSet::addExactVisibility},
                                              {"apv", true, &MethodSet::addApv},
                                              {"ddgi", true, &MethodSet::addDdgi}};

const MethodSet::Baseline* baselineOf(const std::string& command_name) {
  const auto* found = std::ranges::find_if(
      kBaselines, [&](const MethodSet::Baseline& baseline) { return command_name.starts_with(baseline.name); });
  return found == std::end(kBaselines) ? nullptr : found;
}

// Of a sheet's two rules the other one.
std::string withRule(const std::string& name, SheetBacks backs) {
  return backs == SheetBacks::none ? name + ", backless sheets" : name;
}

WeightsAt weightsAt(const Weighting& weighting) {
  return [&weighting](const glm::dvec3& position_m, ProbeWeights* weights) {
    *weights = weighting.weightsAt(position_m, randomNormal(position_m));
  };
}

size_t treeBytes(const ProbeTree& tree) {
  LightGrid grid;
  grid.tree = tree;
  grid.probe_function.assign(tree.probeCount(), kNoWeight);
  return lightGridBytes(grid, {ThetaPrecision::float16, {}}).tree;
}

// What a file keeps of light, and in how many bytes.
// probe_function   of a light grid's probes: those without weight have no light. Of other methods all have the same
std::vector<LightSh> packedAndBack(double error, const ProbeTree& tree, const std::vector<LightSh>& light,
                                   std::vector<uint32_t> probe_function, size_t* bytes) {
  LightGrid grid;
  grid.tree = tree;
  grid.probe_function = std::move(probe_function);
  grid.light = floatsOf(light);
  roundGridLight(error, &grid);
  *bytes = packedLightBytes(grid);
  std::vector<LightSh> kept(light.size());
  for (size_t i = 0; i < grid.light.size(); ++i)
    kept[i / kShFloats][i % kShFloats / kShChannels][static_cast<int>(i % kShChannels)] = grid.light[i];
  return kept;
}

}  // namespace

MethodSet::MethodSet(const MethodScene& scene, const MethodSetOptions& options)
    : scene_(scene),
      options_(options),
      probes_(
          makeProbeSet(scene.tree, scene.transport, {options.probe, options.thread_count, mixSeed(options.seed, kProbeStream)})),
      tree_bytes_(treeBytes(scene.tree)) {
  // light at sample points is measured once for all methods that are solved for
  const double start = processorSeconds();
  GatherOptions place = options.solve.place;
  const std::unique_ptr<SurfaceCache> cache =
      makeSurfaceCache(scene.transport, scene.air.places, scene.air.spacing_m, options.solve, options.thread_count);
  place.cache = cache.get();
  place_light_ = measureLight(scene.transport, scene.air.places, place, options.solve.seed, options.thread_count);
  measure_s_ = processorSeconds() - start;
}

const Weighting& MethodSet::own(std::unique_ptr<Weighting> weighting) { return *weightings_.emplace_back(std::move(weighting)); }

const std::vector<LightSh>& MethodSet::own(std::vector<LightSh> light) { return lights_.emplace_back(std::move(light)); }

MethodBytes MethodSet::bytesOf(size_t weight_bytes) const { return {0, weight_bytes, tree_bytes_}; }

void MethodSet::addBlends(Blends blends) {
  const Weighting& weighting = own(std::move(blends.weighting));
  for (const LightWay way : blends.ways) {
    LightMethod method;
    method.weights = blends.name;
    method.light = way == LightWay::point ? "point" : "solved";
    method.weighting = &weighting;
    method.probes = blends.probes;
    method.bytes = blends.bytes;
    method.weights_s = blends.weights_s;
    const double start = processorSeconds();
    std::vector<LightSh> light;
    if (way == LightWay::point && blends.point_light != nullptr) {
      light = *blends.point_light;
    } else {
      // a point sample in solid says nothing: such probes hold the mean of light under their weights
      ProbeLightOptions options = options_.solve;
      options.way = way == LightWay::point ? LightWay::integrated : LightWay::solved;
      light = lightProbes(scene_.transport, probes_.tree, scene_.air.places, place_light_, weightsAt(weighting), options,
                          options_.thread_count)
                  .light;
      for (size_t p = 0; p < light.size() && way == LightWay::point; ++p) {
        if (probes_.is_in_air[p]) light[p] = probes_.light[p];
      }
    }
    // a method's light takes the time that its gathering or measuring took
    method.light_s = processorSeconds() - start + (way == LightWay::point ? probes_.gather_s : measure_s_);
    // whoever counts bytes of harmonics for itself has 8 bits or more for each
    const bool has_own_bytes = blends.bytes.light > 0;
    // through the file's packing: methods are compared with the light that they would store
    size_t light_bytes = 0;
    const std::vector<LightSh>& kept = own(packedAndBack(
        has_own_bytes ? kLeastLightError : options_.light_error, probes_.tree, light,
        blends.probe_function.empty() ? std::vector<uint32_t>(light.size(), kFreeSpace) : blends.probe_function, &light_bytes));
    if (!has_own_bytes) method.bytes.light = light_bytes;
    method.probe_light = &kept;
    method.light_at = blendedLight(weighting, kept);
    methods_.push_back(std::move(method));
  }
}

std::span<const MethodSet::Baseline> MethodSet::baselines() { return kBaselines; }

bool MethodSet::isBaseline(const std::string& command_name) { return baselineOf(command_name) != nullptr; }

std::string MethodSet::commandName(const LightMethod& method) {
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

void MethodSet::addNamed(const std::string& command_name) {
  if (named(command_name) != nullptr) return;
  if (command_name == kDdgi || command_name == kShippedDdgi) return addShippedDdgi();
  if (const Baseline* baseline = baselineOf(command_name)) (this->*baseline->add)(kGatheredAndSolved);
}

const LightMethod* MethodSet::named(const std::string& command_name) const {
  const std::string& whole = command_name == kDdgi ? kShippedDdgi : command_name;
  const auto found = std::ranges::find_if(methods_, [&](const LightMethod& method) { return commandName(method) == whole; });
  return found == methods_.end() ? nullptr : &*found;
}

void MethodSet::addTrilinear(TrilinearKind kind, const std::vector<LightWay>& ways) {
  auto weighting = std::make_unique<Trilinear>(kind, probes_, scene_.transport.rays());
  if (kind == TrilinearKind::all) {
    addBlends({"trilinear", std::move(weighting), probes_.count(), bytesOf(0), 0.0, &probes_.light, ways});
    return;
  }
  // a bit each says which probes are in air
  const MethodBytes bytes = bytesOf((probes_.count() + 7) / 8);
  const char* name = kind == TrilinearKind::valid ? "valid trilinear" : "exact visibility";
  addBlends({name, std::move(weighting), probes_.air_count, bytes, 0.0, nullptr, ways});
}

void MethodSet::addApv(const std::vector<LightWay>& ways) {
  apv_ = std::make_unique<ApvProbes>(
      bakeApvProbes(probes_, scene_.transport, {options_.probe, options_.thread_count, mixSeed(options_.seed, kApvStream)}));
  const MethodBytes bytes = {probes_.count() * (kApvBytes - 1), probes_.count(), tree_bytes_};
  addBlends({"APV", std::make_unique<Apv>(probes_, *apv_), probes_.count(), bytes, apv_->bake_s, &apv_->light, ways});
}

// In RTXGI's formats.
const DdgiMaps& MethodSet::addDdgi(const std::string& name, const DdgiMaps& maps) {
  const DdgiMaps& shipped = maps_.emplace_back(asShipped(maps));
  const auto& ddgi = static_cast<const Ddgi&>(own(std::make_unique<Ddgi>(probes_, shipped)));
  LightMethod method;
  method.weights = name;
  method.light = "own";
  method.weighting = &ddgi;
  method.probes = probes_.count();
  method.bytes = {probes_.count() * kDdgiShippedBytes, 0, tree_bytes_};
  method.light_s = maps.bake_s;
  method.light_at = lightOf(&ddgi);
  methods_.push_back(std::move(method));
  return shipped;
}

const DdgiMaps& MethodSet::makeDdgi(SheetBacks backs, bool relocates) {
  return maps_.emplace_back(makeDdgiMaps(
      probes_, scene_.transport, {options_.probe, backs, relocates, options_.thread_count, mixSeed(options_.seed, kDdgiStream)}));
}

void MethodSet::addShippedDdgi() { shipped_ddgi_ = &addDdgi(kDdgiAsShipped, makeDdgi(SheetBacks::as_wound, false)); }

void MethodSet::addDdgi(const std::vector<LightWay>& ways) {
  for (const SheetBacks backs : {SheetBacks::as_wound, SheetBacks::none}) {
    if (backs == SheetBacks::none && !hasSheets(scene_.transport.scene())) continue;
    const DdgiMaps& maps = makeDdgi(backs, false);
    addDdgi(withRule(kDdgiAsShipped, backs), maps);
    addDdgi(withRule(kDdgiAsShipped, backs) + kRelocated, makeDdgi(backs, true));
    // its weights with light in harmonics, so that light and weights are told apart
    if (std::ranges::find(ways, LightWay::solved) != ways.end())
      addBlends({withRule("DDGI's weights", backs), std::make_unique<Ddgi>(probes_, maps), probes_.count(),
                 bytesOf(probes_.count() * kDdgiShippedDepthBytes), maps.bake_s, nullptr, ways});
  }
}

void MethodSet::addTargetFunctions(const std::vector<glm::dvec3>& places, const DiffusionOptions& diffusion,
                                   const std::vector<LightWay>& ways) {
  std::vector<glm::dvec3> all = places;
  all.insert(all.end(), scene_.air.places.begin(), scene_.air.places.end());
  const double start = processorSeconds();
  auto functions = std::make_unique<TargetFunctions>(all, probes_, scene_.transport.rays(), diffusion, options_.thread_count);
  const double seconds = processorSeconds() - start;
  // 8,192 samples in 8 bits each
  addBlends({"target functions", std::move(functions), probes_.count(), bytesOf(probes_.count() * kSupportPointCount), seconds,
             nullptr, ways});
}

void MethodSet::addShOctrees(const std::vector<glm::dvec3>& places, const std::vector<LightSh>& light,
                             const std::vector<size_t>& kilobytes) {
  ShOctreeOptions octree;
  for (const size_t budget : kilobytes) octree.byte_budgets.push_back(1024 * budget);
  constexpr size_t kLightBytes = 8;  // of a probe, about: what it takes is known once there is light
  octree.bytes = [](const ProbeTree& tree) { return tree.probeCount() * kLightBytes + treeBytes(tree); };
  octree.solve = options_.solve;
  octree.thread_count = options_.thread_count;
  octree.seed = mixSeed(options_.seed, kOctreeStream);
  // one growing tree comes past all budgets
  for (ShOctree& grown : growShOctrees(scene_.transport, places, light, octree)) {
    const ProbeTree& tree = octrees_.emplace_back(std::move(grown.tree));
    const Weighting& weighting = own(std::make_unique<ShOctreeWeighting>(tree));
    LightMethod method;
    const std::vector<LightSh>& kept = own(packedAndBack(
        options_.light_error, tree, grown.light, std::vector<uint32_t>(grown.light.size(), kFreeSpace), &method.bytes.light));
    method.weights = "SH octree, " + std::to_string(grown.byte_budget / 1024) + " kB";
    method.light = "solved";
    method.light_at = blendedLight(weighting, kept);
    method.weighting = &weighting;
    method.bytes.tree = treeBytes(tree);
    method.probes = kept.size();
    method.light_s = grown.bake_s;
    method.probe_light = &kept;
    methods_.push_back(std::move(method));
  }
}

void MethodSet::addGrid(const std::string& name, LightGrid grid, double bake_s, const std::vector<LightWay>& ways) {
  const LightGrid& kept = grids_.emplace_back(std::move(grid));
  const LightGridBytes bytes = lightGridBytes(kept, {options_.theta, {}});
  size_t with_weight = 0;
  for (const uint32_t function : kept.probe_function) with_weight += function != kNoWeight;
  const size_t first = methods_.size();
  const glm::dvec3& origin_m = scene_.transport.scene().origin_m;
  addBlends({name, std::make_unique<GridWeighting>(kept, origin_m), with_weight,
             bytesOf(bytes.theta + bytes.dictionaries + bytes.functions + bytes.probe_function), bake_s, nullptr, ways,
             kept.probe_function});
  // a copy of the grid for each way of lighting, so that answers come from the look-up itself
  for (size_t m = first, end = methods_.size(); m < end; ++m) {
    LightGrid& lit = grids_.emplace_back(kept);
    lit.light = floatsOf(*methods_[m].probe_light);
    methods_[m].light_at = gridLight(lit, origin_m);
    if (ways != kGatheredAndSolved || methods_[m].light != "solved") continue;
    for (const double error : options_.thin_errors) addThinned(methods_[m], kept, error);
  }
}

void MethodSet::addThinned(const LightMethod& whole, LightGrid grid, double error) {
  const double start = processorSeconds();
  const glm::dvec3& origin_m = scene_.transport.scene().origin_m;
  const auto beside =
      placesBesideSurfaces(scene_.transport.rays(), scene_.air.places, scene_.air.spacing_m, options_.seed, kBesideEvery);
  GridThinner thinner(&grid, origin_m, scene_.air.places, {&place_light_}, beside, {whole.probe_light}, options_.solve.dark_share,
                      options_.thread_count);
  thinner.thinTo(error);
  grid.dropUnusedFunctions();
  std::ostringstream name;
  name << whole.weights << kThinned << error;
  addGrid(name.str(), std::move(grid), whole.weights_s + processorSeconds() - start, {LightWay::solved});
}

}  // namespace nlg
