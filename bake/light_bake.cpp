#include "bake/light_bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>

#include <fmt/format.h>

#include "light/air.h"
#include "light/surface_cache.h"
#include "runtime_eval/light_grid/light_grid_file.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"
#include "tool/quantity.h"

namespace nlg {
namespace {

constexpr uint64_t kLightStream = 0x6c69676874;

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Options and files may ask for more than a file can hold.
InputError tooBright(const std::string& scene) {
  return {scene, "light", "lamps, suns, sky and emission that bring no probe beyond 1e9",
          "more: scale them all down, and exposure up"};
}

double meanOf(const std::vector<LightSh>& light) {
  // the mean of radiance over directions is its first coefficient times Y00
  double sum = 0.0;
  for (const LightSh& sh : light) sum += 0.28209479 * (sh[0].r + sh[0].g + sh[0].b) / 3.0;
  return light.empty() ? 0.0 : sum / static_cast<double>(light.size());
}

void takeLight(const ProbeLight& lit, const std::vector<std::string>& group_names, LightGrid* grid) {
  grid->light = floatsOf(lit.light);
  grid->groups.clear();
  for (size_t g = 0; g < lit.groups.size(); ++g) grid->groups.push_back({group_names[g], floatsOf(lit.groups[g])});
}

std::vector<const std::vector<LightSh>*> lightsOf(const std::vector<LightSh>& light, const LightByGroup& groups) {
  std::vector<const std::vector<LightSh>*> all;
  for (const std::vector<LightSh>& of_group : groups) all.push_back(&of_group);
  if (all.empty()) all.push_back(&light);
  return all;
}

// The file of a grid, but for its header.
size_t bytesWith(LightGrid grid, const BakeOptions& options, const ProbeLight& lit, const std::vector<std::string>& group_names) {
  grid.dropUnusedFunctions();
  takeLight(lit, group_names, &grid);
  return lightGridBytes(grid, {options.policy.theta_precision, options.light_error}).total();
}

struct ThinningInputs {
  const BakeScene& scene;
  const BakeOptions& options;
  const std::vector<LightSh>& place_light;
  const LightByGroup& place_groups;
  const std::function<ProbeLight()>& solve;  // with the grid's functions as they are
  int threads;
};

// Leaves out what thin_error allows, and more and more where max_bytes asks for it.
// returns  light solved for with what is left
ProbeLight thin(const ThinningInputs& inputs, ProbeLight lit, LightGrid* grid, LightStatistics* statistics) {
  constexpr double kFirstError = 0.01, kErrorGrowth = 1.3;  // of rounds until the budget is kept
  const BakeOptions& options = inputs.options;
  const Scene& scene = inputs.scene.source.scene;
  const std::vector<std::string>& group_names = scene.light.groups.names;
  const double most_bytes = options.max_bytes - static_cast<double>(options.header_bytes);
  const auto isWithin = [&](const ProbeLight& now) {
    return options.max_bytes == 0.0 || static_cast<double>(bytesWith(*grid, options, now, group_names)) <= most_bytes;
  };
  double error = options.thin_error;
  if (error == 0.0 && isWithin(lit)) return lit;
  const Progress progress("thinning");
  const std::vector<glm::dvec3> beside =
      placesBesideSurfaces(inputs.scene.rays, inputs.scene.air.places, options.spacing_m, options.seed, kBesideEvery);
  const ProbeLight whole = std::move(lit);
  GridThinner thinner(grid, scene.origin_m, inputs.scene.air.places, lightsOf(inputs.place_light, inputs.place_groups), beside,
                      lightsOf(whole.light, whole.groups), options.light_dark_share, inputs.threads);
  if (error > 0.0) thinner.thinTo(error);
  // light that is solved for anew takes about as many bytes a probe: it is made when those would do
  lit = whole;
  for (bool is_solved = false;;) {
    const bool is_within = isWithin(lit);
    if (is_within && is_solved) break;
    if (is_within) {
      lit = inputs.solve();
      is_solved = true;
      continue;
    }
    if (error == kMostThinError) {
      const size_t least = bytesWith(*grid, options, lit, group_names) + options.header_bytes;
      throw UsageError("max_bytes", fmt::format("{} or more, or a spacing_m above {:g}", least, options.spacing_m),
                       fmt::format("{:.0f}", options.max_bytes));
    }
    error = std::min(kMostThinError, std::max(kFirstError, kErrorGrowth * error));
    thinner.thinTo(error);
    is_solved = false;
  }
  statistics->functions_whole = grid->functionCount();
  grid->dropUnusedFunctions();
  statistics->functions_thinned = grid->functionCount();
  statistics->thin_error = error;
  statistics->thinned = thinner.thinned();
  statistics->thinned.largest_at_m += scene.origin_m;
  return lit;
}

}  // namespace

std::vector<std::string> lightWarnings(const LightStatistics& statistics) {
  // of radiance, of which 1 shows a white surface at full brightness: a hundredth of what the default sky and sun give to open ground
  constexpr double kNearlyBlack = 0.01;
  std::vector<std::string> warnings;
  if (!statistics.is_lit) return warnings;
  if (statistics.mean == 0.0) {
    warnings.push_back("no light reaches any place in air: what shines is switched off, or walled in");
  } else if (statistics.mean < kNearlyBlack) {
    warnings.push_back(
        fmt::format("nearly black: radiance is {:.2g} on average; --sky 1,1,1 or --sky FILE.hdr gives it a sky, --sun a sun, "
                    "--intensity makes all light brighter; a closed room needs a lamp, or something that shines",
                    statistics.mean));
  }
  if (statistics.packing.too_dark > 0) {
    warnings.push_back(
        fmt::format("{} below 1e-12 of the brightest: dark in the file", countText(statistics.packing.too_dark, "probe")));
  }
  if (!statistics.buried_lamps_m.empty()) {
    const glm::dvec3& at = statistics.buried_lamps_m.front();
    warnings.push_back(fmt::format(
        "{} in solid, the first at {:.2f}, {:.2f}, {:.2f}: their light is lost; faces around them may look the wrong way",
        countText(statistics.buried_lamps_m.size(), "lamp"), at.x, at.y, at.z));
  }
  if (statistics.largest > kMaxEngineLight)
    warnings.push_back(fmt::format("light reaches {:.3g}, and engines' files hold {:g}: give nlg-export engine --intensity {:g}",
                                   statistics.largest, kMaxEngineLight, intensityThatFits(statistics.largest)));
  return warnings;
}

static_assert(kMostLightGroups == kMaxLightGroups, "a grid holds every group of a scene");

ProbeLightOptions probeLightOptions(const BakeOptions& options) {
  ProbeLightOptions light;
  light.caches_surfaces = options.light_cache;
  light.place.rays = options.light_rays;
  light.probe.rays = options.light_probe_rays;
  light.place.direct = light.probe.direct = directLightFromName(options.light_direct);
  light.pull = options.light_pull;
  light.dark_share = options.light_dark_share;
  light.outlier = options.light_outlier;
  light.seed = mixSeed(options.seed, kLightStream);
  return light;
}

LightStatistics bakeLight(const BakeScene& scene, const BakeOptions& options, LightGrid* grid) {
  grid->light.clear();
  grid->groups.clear();
  LightStatistics statistics;
  if (options.light == "none") return statistics;
  ProbeLightOptions light_options = probeLightOptions(options);
  light_options.way = lightWayFromName(options.light);
  const int threads = options.threads > 0 ? options.threads : machineThreadCount();
  const LightTransport transport(scene.source.scene, scene.rays);
  statistics.is_lit = true;
  statistics.is_gathered = transport.isBaked();
  statistics.groups = scene.source.scene.light.groups.names;
  statistics.places = scene.air.places.size();
  statistics.rays_per_place = static_cast<uint64_t>(light_options.place.rays);

  Clock::time_point start = Clock::now();
  std::unique_ptr<SurfaceCache> cache;
  if (light_options.caches_surfaces)
    cache =
        makeSurfaceCache(transport, scene.air.places, options.spacing_m, light_options.place.rays, light_options.seed, threads);
  if (cache != nullptr) {
    statistics.cache_cells = cache->cellCount();
    statistics.cache_divided = cache->dividedCount();
    statistics.cache_wall_s = secondsSince(start);
    light_options.place.cache = light_options.probe.cache = cache.get();
  }

  start = Clock::now();
  LightByGroup place_groups;
  const std::vector<LightSh> place_light =
      measureLight(transport, scene.air.places, light_options.place, light_options.seed, threads, &place_groups);
  statistics.measure_wall_s = secondsSince(start);
  statistics.mean = meanOf(place_light);
  for (const Lamp& lamp : scene.source.scene.light.lamps) {
    const glm::dvec3 at(lamp.position);
    if (!isInAir(scene.rays, at)) statistics.buried_lamps_m.push_back(scene.source.scene.origin_m + at);
  }

  start = Clock::now();
  const auto solve = [&] {
    return lightProbes(transport, scene.tree, scene.air.places, place_light, weightsOf(*grid, scene.source.scene.origin_m),
                       light_options, threads, place_groups);
  };
  ProbeLight lit = solve();
  if (options.thin_error > 0.0 || options.max_bytes > 0.0)
    lit = thin({scene, options, place_light, place_groups, solve, threads}, std::move(lit), grid, &statistics);
  statistics.solve_wall_s = secondsSince(start);
  statistics.unread_probes = lit.unread - statistics.thinned.probes;
  statistics.solve_iterations = lit.iterations;
  statistics.error = lit.error;
  statistics.median_error = lit.median_error;
  statistics.p95_error = lit.p95_error;
  if (!scene.air.places.empty()) statistics.worst_m = scene.source.scene.origin_m + scene.air.places[lit.worst_place];
  takeLight(lit, scene.source.scene.light.groups.names, grid);
  for (const float coefficient : grid->light) statistics.largest = std::max(statistics.largest, std::fabs(double{coefficient}));
  if (!checkLight(grid->light).ok()) throw tooBright(scene.source.id);
  statistics.packing = roundGridLight(options.light_error, grid);
  statistics.file_bytes = packedLightBytes(grid->packed_light);
  if (!checkLight(grid->light).ok()) throw tooBright(scene.source.id);
  return statistics;
}

}  // namespace nlg
