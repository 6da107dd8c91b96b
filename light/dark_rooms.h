// Rooms that no light reaches, and in which somebody can stand.
#pragma once

#include <cstdint>
#include <vector>

#include "light/air_places.h"
#include "light/light_transport.h"

namespace nlg {

// Connected air under a roof: places that see others of it, and none that is lit.
struct DarkRoom {
  glm::dvec3 eye_m{0.0};   // of a figure that stands there, relative to the scene's origin
  double volume_m3 = 0.0;  // of its air
};

inline constexpr double kDarkOfMean = 1e-4;  // of the mean light over places: what has no more is dark

// The largest first. What touches lit air, lies open above, or has no floor with room for a figure is none.
// tree      of the places, in the scene's coordinates
// is_dark   by place
std::vector<DarkRoom> findDarkRooms(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& air,
                                    const std::vector<uint8_t>& is_dark);

}  // namespace nlg
