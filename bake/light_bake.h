// Lights the probes of a baked grid.
#pragma once

#include <string>
#include <vector>

#include "bake/prepared_scene.h"
#include "light/probe_light.h"
#include "light/standing.h"
#include "light/thinning.h"

namespace nlg {

// Light at the places where it was measured, and how far blends are from it.
struct LightAtPlaces {
  double mean = 0.0;  // radiance over places and directions, the channels' mean: 0 where nothing shines
  double error = 0.0, median_error = 0.0, p95_error = 0.0;  // as ProbeLight has them
  glm::dvec3 worst_m{0.0};                                  // the place where it is worst, world coordinates
};

// Seconds by the clock.
struct LightStatistics : LightAtPlaces {
  bool is_lit = false;              // whether light was baked at all
  std::vector<std::string> groups;  // of light, which the grid keeps apart; none: it is one
  bool is_gathered = false;         // all bounces came from the level's own light: one ray held them
  uint64_t places = 0, rays_per_place = 0;
  uint64_t unseen_places = 0;  // of these: dark that nobody sees (light/standing.h), which the solve leaves out
  uint64_t unread_probes = 0;  // that weigh nothing at any place
  int solve_iterations = 0;
  uint64_t cache_cells = 0, cache_divided = 0;          // of surface; those that walls divide are not used
  double cache_wall_s = 0.0;                            // bounces between surfaces
  double measure_wall_s = 0.0;                          // light at places
  double solve_wall_s = 0.0;                            // weights at places, and the solve
  double thin_error = 0.0;                              // with which thinned came about; 0: nothing was left out
  Thinned thinned;                                      // largest_at_m: world coordinates
  uint64_t functions_whole = 0, functions_thinned = 0;  // distinct ones, before and after
  LightPacking packing;                                 // what the file's form of it adds
  uint64_t file_bytes = 0;                              // of light
  std::vector<glm::dvec3> buried_lamps_m;               // in solid: nothing is lit by them; world coordinates
  std::vector<DarkRoom> dark_rooms;                     // that no light reaches; world coordinates
  double largest = 0.0;                                 // |coefficient| of a probe
};

// What a bake's light may come to without an error, and is seldom what was meant: black, nearly black, dark in rooms, or brighter than
// engines' files hold. A line each, with what to do; of dark rooms three at most, and one for the others.
std::vector<std::string> lightWarnings(const LightStatistics& statistics);

// What the settings say of light at so many places and of the solve; by the default way.
// throws   UsageError on an unknown name in them, and on 1 to 7 rays of a place
ProbeLightOptions probeLightOptions(const BakeOptions& options, size_t place_count);

// Fills grid->light, and the light of groups, by options.light, as the file will hold it; leaves it empty for "none".
//
// grid      of this scene and its tree, moved to the world's coordinates
// metadata  that the file is going to have: max_bytes counts it
// states    groups of other light states, which the grid keeps: it begins with them, and this light is dark. Not with thinning
// Leaves functions and probes of it out by options.thin_error and options.max_bytes (thinning.h).
// throws   UsageError on an unknown way, and on max_bytes that no thinning keeps; InputError when light is beyond kMaxGridLight
LightStatistics bakeLight(const PreparedScene& scene, const BakeOptions& options, LightGrid* grid,
                          const GridMetadata& metadata = {}, const std::vector<LightGroup>& states = {});

}  // namespace nlg
