#include "bake/bake_in_time.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tool/error.h"
#include "tool/wall_time.h"

namespace nlg {
namespace {

// Samples say what the rest takes to a tenth or so; then the file is still to be written.
constexpr double kSure = 0.9;
constexpr int kFewestRays = 16;   // of a place: with fewer there is more grain than light
constexpr int kFewestPlaces = 4;  // of a cell, of light alone: probes that stand further apart are the better choice
// A level's work goes by so much of the power of its spacing: most of it is where surfaces are, and large supports see more of them.
constexpr double kSpacingPower = 1.7;
constexpr double kLeastCoarser = 1.1;
// How many times as long as a solve thinning takes, which solves twice.
constexpr double kThinning = 3.0;
// Samples of probes that stand further apart have to be made anew: for less than this share of what these took nobody takes that on.
constexpr double kWorthSamples = 0.5;

// So many times as much as with the others: a place has work beside its rays.
double workOfRays(int rays, int others) { return std::pow(static_cast<double>(rays) / others, 0.85); }

bool hasShortFits(const PolicyOptions& policy) {
  return policy.adam_steps + policy.lm_iterations + policy.lm_theta0_iterations + policy.code_iterations > 0;
}

// The scene's grid before it has functions.
LightGrid bareGrid(const BakeScene& scene) {
  LightGrid grid;
  grid.tree = scene.treeInWorld();
  grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  return grid;
}

// By a quarter of the places, with few rays.
BakeCosts lightCosts(BakeScene* scene, const BakeOptions& asked, LightGrid grid) {
  constexpr size_t kBlock = 8, kEvery = 4;  // rays of places that follow one another go into each other's gaps
  constexpr double kCells = 1.5;            // of surface: all places find so many times as many as a quarter of them
  constexpr double kMoreSolve = 2.0;        // which goes by probes as well as by places
  std::vector<glm::dvec3> places;
  for (size_t i = 0; i < scene->air.places.size(); ++i) {
    if (i / kBlock % kEvery == 0) places.push_back(scene->air.places[i]);
  }
  if (asked.light == "none" || places.empty()) return {};
  BakeOptions quick = asked;
  quick.thin_error = 0.0;
  quick.light_rays = std::min(asked.light_rays, kFewestRays);
  const double more_places = static_cast<double>(scene->air.places.size()) / static_cast<double>(places.size());
  scene->air.places.swap(places);
  const auto start = std::chrono::steady_clock::now();
  const LightStatistics light = bakeLight(*scene, quick, &grid);
  const double rest_s = secondsSince(start) - light.cache_wall_s - light.measure_wall_s;
  scene->air.places.swap(places);
  return {{},
          workOfRays(asked.light_rays, quick.light_rays) * (kCells * light.cache_wall_s + more_places * light.measure_wall_s),
          kMoreSolve * (asked.thin_error > 0.0 ? kThinning : 1.0) * rest_s};
}

BakeCosts costsOf(BakeScene* scene, const std::vector<Generator>& generators, const BakeOptions& asked,
                  const std::string& spool_folder) {
  BakeCosts costs = lightCosts(scene, asked, bareGrid(*scene));
  costs.functions = functionCosts(*scene, generators, asked, spool_folder);
  return costs;
}

}  // namespace

double secondsOf(const BakeOptions& chosen, const BakeOptions& asked, const BakeCosts& costs) {
  const double places = static_cast<double>(chosen.light_places) / asked.light_places;
  return costs.functions.rest_s + (hasShortFits(chosen.policy) ? costs.functions.short_fits_s : 0.0) +
         places * (workOfRays(chosen.light_rays, asked.light_rays) * costs.rays_s + costs.solve_s);
}

BakeOptions inTime(const BakeOptions& asked, const BakeCosts& costs, double left_s) {
  BakeOptions chosen = asked;
  const auto fits = [&] { return secondsOf(chosen, asked, costs) <= left_s; };
  if (!fits() && costs.functions.short_fits_s > 0.0) {
    PolicyOptions& policy = chosen.policy;
    policy.adam_steps = policy.lm_iterations = policy.lm_theta0_iterations = policy.code_iterations = 0;
  }
  while (!fits() && chosen.light_rays > kFewestRays) chosen.light_rays = std::max(kFewestRays, chosen.light_rays / 2);
  return chosen;
}

std::string leftOutText(const BakeOptions& asked, const BakeOptions& chosen) {
  std::vector<std::string> parts;
  if (chosen.spacing_m != asked.spacing_m) parts.push_back(fmt::format("probes {:.3g} m apart", chosen.spacing_m));
  if (chosen.light_places != asked.light_places) parts.push_back(fmt::format("{} places a cell", chosen.light_places));
  if (chosen.light_rays != asked.light_rays) parts.push_back(fmt::format("{} rays a place", chosen.light_rays));
  if (hasShortFits(asked.policy) && !hasShortFits(chosen.policy)) parts.push_back("no short fits");
  if (chosen.refine_seconds != asked.refine_seconds) parts.push_back("some functions less refined");
  return fmt::format("{}", fmt::join(parts, ", "));
}

void requireKnownTimes(const BakeOptions& options) {
  const auto refuse = [&](const char* with) {
    throw UsageError("max_seconds", fmt::format("0 with {}: nobody knows beforehand how long that takes", with),
                     fmt::format("{:g}", options.max_seconds));
  };
  if (options.max_bytes > 0.0) refuse("max_bytes");
  if (options.share_rmse > 0.0) refuse("share_rmse");
  if (options.light == "point") refuse("light point");
}

BakedInTime bakeInTime(std::unique_ptr<BakeScene>* scene, const std::vector<Generator>& generators, const BakeOptions& options,
                       const std::string& spool_folder, const std::function<double()>& left_s) {
  const auto surelyLeft = [&] { return kSure * left_s(); };
  BakeOptions asked = options;  // but for its spacing
  asked.max_seconds = 0.0;
  const double most_m = kMostCoarser * options.spacing_m;
  BakeCosts costs;
  bool fits = false;
  for (auto start = std::chrono::steady_clock::now();; start = std::chrono::steady_clock::now()) {
    if (asked.spacing_m != options.spacing_m) *scene = std::make_unique<BakeScene>(std::move((*scene)->source), asked);
    costs = costsOf(scene->get(), generators, asked, spool_folder);
    const double needed_s = secondsOf(inTime(asked, costs, 0.0), asked, costs);
    // whoever has come this far for nothing takes what is about enough
    const double left = asked.spacing_m == options.spacing_m ? surelyLeft() : left_s();
    fits = needed_s <= left + kWorthSamples * secondsSince(start);
    if (fits || asked.spacing_m == most_m) break;
    // the scene and its samples are made anew, too
    const double coarser =
        left > 0.0 ? std::pow((needed_s + secondsSince(start)) / (kSure * left), 1.0 / kSpacingPower) : kMostCoarser;
    asked.spacing_m = std::min(most_m, std::max(kLeastCoarser, coarser) * asked.spacing_m);
  }
  const BakeOptions first = inTime(asked, costs, surelyLeft());
  // refinement and light go by what is left when they begin
  BakedInTime baked{{}, {first, !fits}};
  BakeOptions& chosen = baked.chosen.options;
  const BakeCosts of_light{{}, costs.rays_s, costs.solve_s};
  const auto lightInTime = [&] { return inTime(asked, of_light, surelyLeft()); };
  double refine_seconds = 0.0;
  const BakeInTime in_time{[&] {
                             constexpr double kNone = 1e-9;  // 0 would be no limit
                             refine_seconds = std::max(kNone, surelyLeft() - secondsOf(lightInTime(), asked, of_light));
                             if (asked.refine_seconds > 0.0) refine_seconds = std::min(refine_seconds, asked.refine_seconds);
                             return refine_seconds;
                           },
                           [&] { return chosen.light_rays = lightInTime().light_rays; }};
  baked.bake = bakeScene(**scene, generators, first, spool_folder, {}, nullptr, &in_time);
  if (baked.bake.statistics.left_for_time > 0) chosen.refine_seconds = refine_seconds;
  return baked;
}

ChosenInTime chooseLightInTime(std::unique_ptr<BakeScene>* scene, const KnownAir& known, const LightGrid& grid,
                               const BakeOptions& options, const std::function<double()>& left_s) {
  BakeOptions asked = options;
  asked.max_seconds = 0.0;
  const BakeCosts costs = lightCosts(scene->get(), asked, grid);
  const double left = kSure * left_s();
  ChosenInTime chosen{inTime(asked, costs, left), false};
  if (secondsOf(chosen.options, asked, costs) <= left) return chosen;
  chosen.options.light_places = std::min(asked.light_places, kFewestPlaces);
  chosen.is_coarsest = secondsOf(chosen.options, asked, costs) > left;
  *scene = std::make_unique<BakeScene>(std::move((*scene)->source), chosen.options, known);
  return chosen;
}

}  // namespace nlg
