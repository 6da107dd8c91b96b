// Random places in a level's air, and how far from a surface each is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/probes/probe_placement.h"
#include "datagen/visibility/ray_scene.h"
#include "datagen/visibility/support_visibility.h"
#include "runtime_eval/light_grid/probe_tree.h"

namespace nlg {

// Places are told apart by the distance to the nearest triangle, metres: class i lies below border i and not below the one before.
inline constexpr std::array<double, 3> kDistanceBordersM = {0.05, 0.2, 0.5};
inline constexpr size_t kDistanceClassCount = kDistanceBordersM.size() + 1;

struct PlaceOptions {
  uint64_t places = 8000;        // kept at most, the same number of every class
  uint64_t share_draws = 40000;  // uniform in the extent's volume: they say how much of the air each class is
  uint64_t draws = 400000;       // at most, to fill classes that are rare
  uint64_t seed = 1;
};

struct Place {
  glm::dvec3 position_m;  // relative to the scene's origin; in air, and in a cell of the tree
  uint8_t distance_class = 0;
};

struct Places {
  std::vector<Place> places;                                   // in the order in which they were drawn
  std::array<double, kDistanceClassCount> air_share{};         // of the air in the tree: adds up to 1 where there is any
  std::array<uint64_t, kDistanceClassCount> kept{};            // of places
  uint64_t drawn = 0, in_solid = 0, disputed = 0, in_air = 0;  // of share_draws
  uint64_t outside = 0;                                        // of in_air: in no cell of the tree

  std::vector<glm::dvec3> positions() const;
  // What a place of this class stands for: weights of all places add up to 1, as far as classes have any.
  double weight(uint8_t distance_class) const;
};

// In air is what the 14 rays call so that tell a probe in solid; disputed places do not count (docs/theory/visibility.md).
// The same seed gives the same places.
//
// extent   relative to the scene's origin
// tree     in the scene's coordinates
Places drawPlaces(const ExtentBox& extent, const RayScene& rays, const SupportVisibility& visibility, const ProbeTree& tree,
                  const PlaceOptions& options);

}  // namespace nlg
