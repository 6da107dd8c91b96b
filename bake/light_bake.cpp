#include "bake/light_bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>

#include <fmt/format.h>

#include "light/air.h"
#include "light/surface_cache.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/printable.h"
#include "tool/processor_time.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kLightStream = 0x6c69676874;
constexpr int kFewestRays = 8;  // of a place: one for each set whose spread tells their noise

using Clock = std::chrono::steady_clock;

// Options and files may ask for more than a file can hold.
InputError tooBright(const std::string& scene) {
  return {scene, "light", "lamps, suns, sky and emission that bring no probe beyond 1e9",
          "more: scale them all down, and exposure up"};
}

// The mean of radiance over directions is its first coefficient times Y00.
double meanOf(const LightSh& sh) { return 0.28209479 * (sh[0].r + sh[0].g + sh[0].b) / 3.0; }

double meanOf(const std::vector<LightSh>& light) {
  double sum = 0.0;
  for (const LightSh& sh : light) sum += meanOf(sh);
  return light.empty() ? 0.0 : sum / static_cast<double>(light.size());
}

// states   of light that the grid keeps besides, and begins with
void takeLight(const ProbeLight& lit, const std::vector<std::string>& names, const std::vector<LightGroup>& states,
               LightGrid* grid) {
  grid->groups = states;
  for (size_t g = 0; g < lit.groups.size(); ++g) grid->groups.push_back({names[g], floatsOf(lit.groups[g]), !states.empty()});
  grid->light = floatsOf(lit.light);
  if (states.empty()) return;
  std::fill(grid->light.begin(), grid->light.end(), 0.0f);
  for (const LightGroup& group : states) {
    if (group.begins_dark) continue;
    for (size_t i = 0; i < grid->light.size(); ++i) grid->light[i] += group.light[i];
  }
}

// Of each group of a grid; of one without groups all of it.
std::vector<const std::vector<LightSh>*> lightsOf(const std::vector<LightSh>& light, const LightByGroup& groups) {
  std::vector<const std::vector<LightSh>*> all;
  for (const std::vector<LightSh>& of_group : groups) all.push_back(&of_group);
  if (groups.empty()) all.push_back(&light);
  return all;
}

void findBuriedLamps(const PreparedScene& scene, LightStatistics* statistics) {
  for (const Lamp& lamp : scene.source.scene.light.lamps) {
    const glm::dvec3 at(lamp.position);
    if (!isInAir(scene.rays, at)) statistics->buried_lamps_m.push_back(scene.source.scene.origin_m + at);
  }
}

void findDark(const PreparedScene& scene, const LightTransport& transport, const std::vector<LightSh>& place_light,
              LightStatistics* statistics) {
  const double most = kDarkOfMean * meanOf(place_light);
  if (!(most > 0.0)) return;
  std::vector<uint8_t> is_dark;
  for (const LightSh& light : place_light) is_dark.push_back(meanOf(light) <= most);
  statistics->dark_rooms = findDarkRooms(transport, scene.tree, scene.air, is_dark);
  for (DarkRoom& room : statistics->dark_rooms) room.eye_m += scene.source.scene.origin_m;
}

// Of the file that a grid would be.
size_t bytesWith(LightGrid grid, const BakeOptions& options, const GridMetadata& metadata, const ProbeLight& lit,
                 const std::vector<std::string>& names) {
  grid.dropUnusedFunctions();
  takeLight(lit, names, {}, &grid);
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {options.policy.theta_precision, options.light_error}, metadata, &bytes);
  if (!result.ok()) throw NumericalError("bake: light grid: " + result.detail + ": a number that the file cannot hold");
  return bytes.size();
}

struct ThinningInputs {
  const PreparedScene& scene;
  const BakeOptions& options;
  const GridMetadata& metadata;
  const std::vector<std::string>& names;                     // of groups
  const std::vector<const std::vector<LightSh>*>& measured;  // by group, at places
  const std::function<ProbeLight()>& solve;                  // with the grid's functions as they are
  int threads;
};

// Leaves out what thin_error allows, and more and more where max_bytes asks for it.
// returns  light solved for with what is left
ProbeLight thin(const ThinningInputs& inputs, ProbeLight lit, LightGrid* grid, LightStatistics* statistics) {
  constexpr double kFirstError = 0.01, kErrorGrowth = 1.3;  // of rounds until the budget is kept
  const BakeOptions& options = inputs.options;
  const Scene& scene = inputs.scene.source.scene;
  const auto bytesNow = [&](const ProbeLight& now) { return bytesWith(*grid, options, inputs.metadata, now, inputs.names); };
  const auto isWithin = [&](const ProbeLight& now) {
    return options.max_bytes == 0.0 || static_cast<double>(bytesNow(now)) <= options.max_bytes;
  };
  double error = options.thin_error;
  if (error == 0.0 && isWithin(lit)) return lit;
  const Progress progress("thinning");
  const std::vector<glm::dvec3> beside =
      placesBesideSurfaces(inputs.scene.rays, inputs.scene.air.places, inputs.scene.air.spacing_m, options.seed, kBesideEvery);
  // all changes are measured from the light of the whole grid
  const ProbeLight whole = std::move(lit);
  GridThinner thinner(grid, scene.origin_m, inputs.scene.air.places, inputs.measured, beside, lightsOf(whole.light, whole.groups),
                      options.light_dark_share, inputs.threads);
  if (error > 0.0) thinner.thinTo(error);
  // light that is solved for anew takes about as many bytes a probe: it is made when those would do
  lit = whole;
  for (;;) {
    if (isWithin(lit) || error == kMostThinError) {
      lit = inputs.solve();
      if (isWithin(lit)) break;
    }
    if (error == kMostThinError) {
      // a size that is taken: the file names it, and other digits are some bytes more or less
      const size_t least = (bytesNow(lit) + 32 + 99) / 100 * 100;
      throw UsageError(
          "max_bytes",
          fmt::format("at least {} bytes with probes {:g} m apart, or a larger spacing_m", least, inputs.scene.air.spacing_m),
          fmt::format("{:.0f}", options.max_bytes));
    }
    // too large still: allows more error, in steps that find a size near the limit
    error = std::min(kMostThinError, std::max(kFirstError, kErrorGrowth * error));
    thinner.thinTo(error);
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
    warnings.push_back("no light reaches any point in air: lights are switched off, or walled in");
  } else if (statistics.mean < kNearlyBlack) {
    warnings.push_back(
        fmt::format("nearly black: radiance is {:.2g} on average; --sky 1,1,1 or --sky FILE.hdr gives it a sky, --sun a sun, "
                    "--intensity makes all light brighter; a closed room needs a lamp, or something that shines",
                    statistics.mean));
  }
  constexpr size_t kMostRooms = 3;
  for (size_t r = 0; r < std::min(kMostRooms, statistics.dark_rooms.size()); ++r) {
    const DarkRoom& room = statistics.dark_rooms[r];
    warnings.push_back(
        fmt::format("no light reaches a room of {:.0f} m3 around {:.1f}, {:.1f}, {:.1f}, where a player can stand: it "
                    "needs a lamp, or something that shines",
                    room.volume_m3, room.eye_m.x, room.eye_m.y, room.eye_m.z));
  }
  if (statistics.dark_rooms.size() > kMostRooms)
    warnings.push_back(fmt::format("no light reaches {}, smaller than these",
                                   countText(statistics.dark_rooms.size() - kMostRooms, "other room")));
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
    warnings.push_back(fmt::format("light reaches {:.3g}, and engines' files hold {:g}: {:g} times this --intensity makes it fit",
                                   statistics.largest, kMaxEngineLight, intensityThatFits(statistics.largest)));
  return warnings;
}

ProbeLightOptions probeLightOptions(const BakeOptions& options, size_t place_count) {
  if (options.light_rays > 0 && options.light_rays < kFewestRays)
    throw UsageError("light_rays", fmt::format("0, or at least {}", kFewestRays), std::to_string(options.light_rays));
  ProbeLightOptions light;
  light.caches_surfaces = options.light_cache;
  light.place.rays = options.light_rays > 0 ? options.light_rays : raysOfPlace(place_count);
  light.probe.rays = options.light_probe_rays;
  light.place.direct = light.probe.direct = directLightFromName(options.light_direct);
  light.pull = options.light_pull;
  light.dark_share = options.light_dark_share;
  light.outlier = options.light_outlier;
  light.seed = mixSeed(options.seed, kLightStream);
  return light;
}

LightStatistics bakeLight(const PreparedScene& scene, const BakeOptions& options, LightGrid* grid, const GridMetadata& metadata,
                          const std::vector<LightGroup>& states) {
  grid->light.clear();
  grid->groups.clear();
  LightStatistics statistics;
  if (options.light == "none") return statistics;
  ProbeLightOptions light_options = probeLightOptions(options, scene.air.places.size());
  light_options.way = lightWayFromName(options.light);
  const int threads = threadsOf(options);
  const glm::dvec3& origin_m = scene.source.scene.origin_m;
  const LightGroups& groups = scene.source.scene.light.groups;
  const LightTransport transport(scene.source.scene, scene.rays);
  statistics.is_lit = true;
  statistics.is_gathered = transport.isBaked();
  statistics.groups = groups.names;
  statistics.places = scene.air.places.size();
  statistics.rays_per_place = static_cast<uint64_t>(light_options.place.rays);

  // bounces between surfaces, once for all sample points
  Clock::time_point start = Clock::now();
  const std::unique_ptr<SurfaceCache> cache =
      makeSurfaceCache(transport, scene.air.places, scene.air.spacing_m, light_options, threads);
  if (cache != nullptr) {
    statistics.cache_cells = cache->cellCount();
    statistics.cache_divided = cache->dividedCount();
    light_options.place.cache = light_options.probe.cache = cache.get();
  }
  statistics.cache_wall_s = secondsSince(start);

  // light at sample points in air, and what it shows of dark rooms and buried lamps
  start = Clock::now();
  LightByGroup place_groups;
  const std::vector<LightSh> place_light = measureLight(transport, scene.air.places, light_options.place, light_options.seed,
                                                        threads, groups.areMany() ? &place_groups : nullptr);
  findBuriedLamps(scene, &statistics);
  findDark(scene, transport, place_light, &statistics);
  statistics.measure_wall_s = secondsSince(start);

  // probes' light, and once more after thinning, with what is left
  start = Clock::now();
  const auto solve = [&] {
    ProbeLight lit = lightProbes(transport, scene.tree, scene.air.places, place_light, weightsOf(*grid, origin_m), light_options,
                                 threads, place_groups);
    static_cast<LightAtPlaces&>(statistics) = {meanOf(place_light), lit.error, lit.median_error, lit.p95_error};
    if (!scene.air.places.empty()) statistics.worst_m = origin_m + scene.air.places[lit.worst_place];
    const std::vector<float> coefficients = floatsOf(lit.light);
    if (!checkLight(coefficients).ok()) throw tooBright(scene.source.id);
    statistics.largest = 0.0;
    for (const float coefficient : coefficients)
      statistics.largest = std::max(statistics.largest, std::fabs(double{coefficient}));
    if (!groups.names.empty() && lit.groups.empty()) lit.groups.push_back(lit.light);
    return lit;
  };
  ProbeLight lit = solve();
  if (options.thin_error > 0.0 || options.max_bytes > 0.0)
    lit = thin({scene, options, metadata, groups.names, lightsOf(place_light, place_groups), solve, threads}, std::move(lit),
               grid, &statistics);
  statistics.solve_wall_s = secondsSince(start);
  // what thinning left out is unread on purpose
  statistics.unread_probes = lit.unread - statistics.thinned.probes;
  statistics.unseen_places = lit.unseen;
  statistics.solve_iterations = lit.iterations;
  takeLight(lit, groups.names, states, grid);
  // rounded as the file stores it, so that grid, report and file have one light
  statistics.packing = roundGridLight(options.light_error, grid);
  statistics.file_bytes = packedLightBytes(*grid);
  if (!checkLight(grid->light).ok()) throw tooBright(scene.source.id);
  return statistics;
}

}  // namespace nlg
