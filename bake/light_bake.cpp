#include "bake/light_bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "light/air.h"
#include "light/surface_cache.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
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
    cache = makeSurfaceCache(transport, scene.air.places, options.spacing_m, light_options.seed, threads);
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
  const ProbeLight lit = lightProbes(transport, scene.tree, scene.air.places, place_light,
                                     weightsOf(*grid, scene.source.scene.origin_m), light_options, threads, place_groups);
  statistics.solve_wall_s = secondsSince(start);
  statistics.unread_probes = lit.unread;
  statistics.solve_iterations = lit.iterations;
  statistics.error = lit.error;
  statistics.median_error = lit.median_error;
  statistics.p95_error = lit.p95_error;
  if (!scene.air.places.empty()) statistics.worst_m = scene.source.scene.origin_m + scene.air.places[lit.worst_place];
  grid->light = floatsOf(lit.light);
  for (size_t g = 0; g < lit.groups.size(); ++g)
    grid->groups.push_back({scene.source.scene.light.groups.names[g], floatsOf(lit.groups[g])});
  for (const float coefficient : grid->light) statistics.largest = std::max(statistics.largest, std::fabs(double{coefficient}));
  if (!checkLight(grid->light).ok()) throw tooBright(scene.source.id);
  statistics.packing = roundGridLight(options.light_error, grid);
  statistics.file_bytes = packedLightBytes(grid->packed_light);
  if (!checkLight(grid->light).ok()) throw tooBright(scene.source.id);
  return statistics;
}

}  // namespace nlg
