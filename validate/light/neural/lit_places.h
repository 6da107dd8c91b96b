// Places in air with the light that was measured there: what methods that learn a scene's light learn it from.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "light/air_places.h"
#include "light/light_transport.h"
#include "light/probe_light.h"
#include "runtime_eval/light_grid/probe_tree.h"

namespace nlg {

struct LitPlaces {
  std::vector<glm::dvec3> position_m;  // relative to the scene's origin
  std::vector<LightSh> light;          // by place
  double measure_s = 0.0;              // by the clock, of those beyond the bake's own
};

// A bake's own places, and others that are drawn and measured as the bake does it, with another seed.
//
// tree         in the scene's coordinates: the cells that places are drawn in
// own, light   the bake's, and what it measured there
// solve        how it measured
// times        >= 1: how many times as many places as the bake has there should be in all
// The same for any number of threads.
LitPlaces drawLitPlaces(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& own,
                        const std::vector<LightSh>& light, const ProbeLightOptions& solve, int times, int thread_count);

// Irradiance, its mean over all normals and channels, of the mean place: the unit in which networks answer. > 0.
float meanIrradiance(const std::vector<LightSh>& light);

// Which places are learned from, and by which it is told when to stop: one in kHeldOutShare.
inline constexpr uint64_t kHeldOutShare = 16;
struct PlaceSplit {
  std::vector<uint32_t> learned, held_out;  // indices, rising
};
PlaceSplit splitPlaces(size_t count, uint64_t seed);

}  // namespace nlg
