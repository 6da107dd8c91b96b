#include "bake/light_bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <iterator>
#include <memory>

#include <fmt/format.h>

#include "light/air.h"
#include "light/surface_cache.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/numbers/random.h"
#include "scene/lights/light_sets.h"
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

// The groups of a grid: names in their order, the first so many of which shine to begin with.
struct GroupsOfGrid {
  std::vector<std::string> names;
  size_t first_count = 0;
};

void takeLight(const ProbeLight& lit, const GroupsOfGrid& groups, LightGrid* grid) {
  grid->light = floatsOf(lit.light);
  grid->groups.clear();
  for (size_t g = 0; g < lit.groups.size(); ++g)
    grid->groups.push_back({groups.names[g], floatsOf(lit.groups[g]), g >= groups.first_count});
}

// Of each group of a grid; of one without groups all of it.
void addLights(const std::vector<LightSh>& light, const LightByGroup& groups, std::vector<const std::vector<LightSh>*>* all) {
  for (const std::vector<LightSh>& of_group : groups) all->push_back(&of_group);
  if (groups.empty()) all->push_back(&light);
}

// One of the ways in which a scene is lit.
struct LitSet {
  LitSet(const Scene& scene, const RayScene& rays) : transport(scene, rays) {}
  LightTransport transport;
  std::unique_ptr<SurfaceCache> cache;
  ProbeLightOptions options;
  std::vector<LightSh> place_light;
  LightByGroup place_groups;
};

// Bounces between surfaces, once for all places of a set.
void cacheSurfaces(const PreparedScene& scene, int threads, std::deque<LitSet>* sets, LightStatistics* statistics) {
  for (LitSet& set : *sets) {
    set.cache = makeSurfaceCache(set.transport, scene.air.places, scene.air.spacing_m, set.options, threads);
    if (set.cache == nullptr) continue;
    statistics->cache_cells += set.cache->cellCount();
    statistics->cache_divided += set.cache->dividedCount();
    set.options.place.cache = set.options.probe.cache = set.cache.get();
  }
}

void measureSets(const PreparedScene& scene, int threads, std::deque<LitSet>* sets, LightStatistics* statistics) {
  const glm::dvec3& origin_m = scene.source.scene.origin_m;
  std::vector<glm::dvec3>& buried_m = statistics->buried_lamps_m;
  for (LitSet& set : *sets) {
    set.place_light =
        measureLight(set.transport, scene.air.places, set.options.place, set.options.seed, threads, &set.place_groups);
    for (const Lamp& lamp : set.transport.scene().light.lamps) {
      const glm::dvec3 at(lamp.position);
      // most lamps are in all sets
      if (!isInAir(scene.rays, at) && std::find(buried_m.begin(), buried_m.end(), origin_m + at) == buried_m.end())
        buried_m.push_back(origin_m + at);
    }
  }
}

// Of places that are dark in every set. Where all are, that is said of the whole.
void findDark(const PreparedScene& scene, const std::deque<LitSet>& sets, LightStatistics* statistics) {
  std::vector<uint8_t> is_dark(scene.air.places.size(), 1);
  bool shines = false;
  for (const LitSet& set : sets) {
    const double most = kDarkOfMean * meanOf(set.place_light);
    shines |= most > 0.0;
    for (size_t p = 0; p < is_dark.size(); ++p) is_dark[p] &= meanOf(set.place_light[p]) <= most;
  }
  if (!shines) return;
  statistics->dark_rooms = findDarkRooms(sets.front().transport, scene.tree, scene.air, is_dark);
  for (DarkRoom& room : statistics->dark_rooms) room.eye_m += scene.source.scene.origin_m;
}

// Each set by itself, by the same functions at the same places: what a bake of it alone would give.
std::vector<ProbeLight> solveSets(const PreparedScene& scene, const LightGrid& grid, const std::deque<LitSet>& sets, int threads,
                                  LightStatistics* statistics) {
  const glm::dvec3& origin_m = scene.source.scene.origin_m;
  const std::vector<std::string>& names = scene.source.light_sets;
  std::vector<ProbeLight> lit;
  statistics->of_sets.clear();
  statistics->largest = 0.0;
  for (const LitSet& set : sets) {
    lit.push_back(lightProbes(set.transport, scene.tree, scene.air.places, set.place_light, weightsOf(grid, origin_m),
                              set.options, threads, set.place_groups));
    const ProbeLight& of_set = lit.back();
    LightAtPlaces at_places{meanOf(set.place_light), of_set.error, of_set.median_error, of_set.p95_error};
    if (!scene.air.places.empty()) at_places.worst_m = origin_m + scene.air.places[of_set.worst_place];
    // the first set is the one that the grid begins with
    if (lit.size() == 1) static_cast<LightAtPlaces&>(*statistics) = at_places;
    if (!names.empty()) statistics->of_sets.emplace_back(names[lit.size() - 1], at_places);
    const std::vector<float> coefficients = floatsOf(of_set.light);
    for (const float coefficient : coefficients)
      statistics->largest = std::max(statistics->largest, std::fabs(double{coefficient}));
    if (!checkLight(coefficients).ok()) throw tooBright(scene.source.id);
  }
  return lit;
}

// What the grid begins with, and the groups of all.
// lit   of each set; not none
ProbeLight joined(std::vector<ProbeLight> lit, const GroupsOfGrid& groups) {
  if (groups.names.empty()) return std::move(lit.front());
  ProbeLight all;
  all.light = lit.front().light;
  all.unread = lit.front().unread;
  all.unseen = lit.front().unseen;
  for (ProbeLight& of_set : lit) {
    if (of_set.groups.empty()) of_set.groups.push_back(std::move(of_set.light));
    std::move(of_set.groups.begin(), of_set.groups.end(), std::back_inserter(all.groups));
    all.iterations += of_set.iterations;
  }
  return all;
}

// Of the file that a grid would be.
size_t bytesWith(LightGrid grid, const BakeOptions& options, const GridMetadata& metadata, const ProbeLight& lit,
                 const GroupsOfGrid& groups) {
  grid.dropUnusedFunctions();
  takeLight(lit, groups, &grid);
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {options.policy.theta_precision, options.light_error}, metadata, &bytes);
  if (!result.ok()) throw NumericalError("bake: light grid: " + result.detail + ": a number that the file cannot hold");
  return bytes.size();
}

struct ThinningInputs {
  const PreparedScene& scene;
  const BakeOptions& options;
  const GridMetadata& metadata;
  const GroupsOfGrid& groups;
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
  const auto bytesNow = [&](const ProbeLight& now) { return bytesWith(*grid, options, inputs.metadata, now, inputs.groups); };
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
  std::vector<const std::vector<LightSh>*> light;
  addLights(whole.light, whole.groups, &light);
  GridThinner thinner(grid, scene.origin_m, inputs.scene.air.places, inputs.measured, beside, light, options.light_dark_share,
                      inputs.threads);
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
      throw UsageError("max_bytes", fmt::format("{} or more, or a spacing_m above {:g}", least, inputs.scene.air.spacing_m),
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
  const auto warnOfDarkness = [&](const std::string& of, double mean) {
    if (mean == 0.0) {
      warnings.push_back(of + "no light reaches any point in air: lights are switched off, or walled in");
    } else if (mean < kNearlyBlack) {
      warnings.push_back(
          of +
          fmt::format("nearly black: radiance is {:.2g} on average; --sky 1,1,1 or --sky FILE.hdr gives it a sky, --sun a sun, "
                      "--intensity makes all light brighter; a closed room needs a lamp, or something that shines",
                      mean));
    }
  };
  for (const auto& [name, light] : statistics.of_sets) warnOfDarkness("light set " + name + ": ", light.mean);
  if (statistics.of_sets.empty()) warnOfDarkness("", statistics.mean);
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
    warnings.push_back(fmt::format("light reaches {:.3g}, and engines' files hold {:g}: --intensity {:g} makes it fit",
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

LightStatistics bakeLight(const PreparedScene& scene, const BakeOptions& options, LightGrid* grid, const GridMetadata& metadata) {
  grid->light.clear();
  grid->groups.clear();
  LightStatistics statistics;
  if (options.light == "none") return statistics;
  ProbeLightOptions light_options = probeLightOptions(options, scene.air.places.size());
  light_options.way = lightWayFromName(options.light);
  const int threads = threadsOf(options);
  const GroupsOfGrid groups{lightGroupNames(scene.source), firstGroupCount(scene.source)};
  // one light, or a set for each of several; all of them share air, rays and functions
  std::deque<LitSet> sets;
  for (const Scene* lit : litScenes(scene.source)) sets.emplace_back(*lit, scene.rays).options = light_options;
  statistics.is_lit = true;
  statistics.is_gathered = sets.front().transport.isBaked();
  statistics.groups = groups.names;
  statistics.places = scene.air.places.size();
  statistics.rays_per_place = static_cast<uint64_t>(light_options.place.rays);

  // bounces between surfaces, once for all sample points
  Clock::time_point start = Clock::now();
  cacheSurfaces(scene, threads, &sets, &statistics);
  statistics.cache_wall_s = secondsSince(start);

  // light at sample points in air, and what it shows of dark rooms and buried lamps
  start = Clock::now();
  measureSets(scene, threads, &sets, &statistics);
  findDark(scene, sets, &statistics);
  statistics.measure_wall_s = secondsSince(start);

  // probes' light, and once more after thinning, with what is left
  start = Clock::now();
  const auto solve = [&] { return joined(solveSets(scene, *grid, sets, threads, &statistics), groups); };
  ProbeLight lit = solve();
  if (options.thin_error > 0.0 || options.max_bytes > 0.0) {
    std::vector<const std::vector<LightSh>*> measured;
    for (const LitSet& set : sets) addLights(set.place_light, set.place_groups, &measured);
    lit = thin({scene, options, metadata, groups, measured, solve, threads}, std::move(lit), grid, &statistics);
  }
  statistics.solve_wall_s = secondsSince(start);
  // what thinning left out is unread on purpose
  statistics.unread_probes = lit.unread - statistics.thinned.probes;
  statistics.unseen_places = lit.unseen;
  statistics.solve_iterations = lit.iterations;
  takeLight(lit, groups, grid);
  // rounded as the file stores it, so that grid, report and file have one light
  statistics.packing = roundGridLight(options.light_error, grid);
  statistics.file_bytes = packedLightBytes(*grid);
  if (!checkLight(grid->light).ok()) throw tooBright(scene.source.id);
  return statistics;
}

}  // namespace nlg
