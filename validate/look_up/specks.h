// Specks: places in air that a look-up lights by what it should not believe.
//
// Of a place in a dark room one probe sees it, its function says almost nothing there, and what is left of other probes' weights, behind
// the wall, is normalised to full light. Such places are so few that no sample of thousands meets them.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/probes/probe_placement.h"
#include "datagen/visibility/ray_scene.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

// Of its tent, less the residue that a look-up takes off: a probe that has less says nothing of a place. It is what the residue leaves
// of a tenth, from where on light is certain.
inline constexpr float kSpeckShare = 0.05f;
inline constexpr float kSpeckLeastTent = 0.001f;  // a probe that sees a place need not say anything where its own tent is less

struct Speck {
  glm::dvec3 position_m{0.0};  // relative to the scene's origin
  float largest_share = 0.0f;  // of its tent that a probe that sees the place has, or any probe where none does
  int seen_by = 0;             // probes
};

struct SpeckOptions {
  uint64_t places = 10000000;  // drawn uniformly in the extent, in solid or not
  size_t most_listed = 10;
  uint64_t seed = 1;
  int threads = 1;  // the same specks for any number
};

struct Specks {
  uint64_t looked_up = 0;  // of the places: in a cell
  uint64_t count = 0;
  std::vector<Speck> first;  // as they were drawn
};

// A place in air is a speck when its light has the status `lit` although no probe that sees it has kSpeckShare of its tent there;
// where none sees it, although no probe at all has.
//
// tree     of the grid, relative to the scene's origin, as extent is
// origin_m the scene's
Specks findSpecks(const LightGrid& grid, const ProbeTree& tree, const glm::dvec3& origin_m, const RayScene& rays,
                  const ExtentBox& extent, const SpeckOptions& options);

}  // namespace nlg
