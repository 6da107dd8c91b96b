// Where a player can stand, rooms there that no light reaches, and dark that nobody sees. A spot is a floor, and room for a figure in the air over it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "light/air_places.h"
#include "light/light_transport.h"

namespace nlg {

inline constexpr double kEyeHeightM = 1.6, kOverEyesM = 0.2;

// A figure: three balls one above another, the lowest on the floor.
struct FigureBall {
  double height_m = 0.0, radius_m = 0.0;
};
inline constexpr FigureBall kFigure[] = {{0.3, 0.3}, {1.0, 0.35}, {1.6, 0.2}};
inline constexpr double kFigureHeightM = 1.85;

struct Spot {
  glm::dvec3 floor_m{0.0}, eye_m{0.0};  // relative to the scene's origin
  double headroom_m = 0.0;
  bool is_upright = false;  // a figure touches nothing but the floor
  bool is_wide = false;     // a stride around it the floor goes on
  bool has_roof = false;    // above it
};

class Spots {
 public:
  // extent   what a bake lights: nobody asks for light beyond, on a roof or past the edge of the ground
  Spots(const LightTransport& transport, const ExtentBox& extent)
      : transport_(transport), rays_(transport.rays()), extent_(extent) {}

  // Straight below a place in air, where somebody can stand or crouch; nothing where an eye would be in no air or against a wall.
  std::optional<Spot> below(const glm::dvec3& place_m) const;
  bool isInExtent(const glm::dvec3& place_m) const;
  bool isBlocked(const glm::dvec3& from, const glm::dvec3& to) const { return rays_.isBlocked(glm::vec3(from), glm::vec3(to)); }

 private:
  bool isFloor(const LightHit& hit) const;
  bool isFreeOfFigure(const glm::dvec3& floor_m) const;
  // Whether the ceiling is low for a stride around: below a table nobody stands, in a low room one crouches.
  bool isLowAround(const Spot& spot) const;
  bool isWide(const Spot& spot) const;

  const LightTransport& transport_;
  const RayScene& rays_;
  const ExtentBox extent_;
};

// A room that no light reaches, and in which somebody can stand: connected air under a roof, places that see others of it, none lit.
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

// Dark sample points whose dark nobody sees.
// - Hollows: what is joined by sight, and in which no figure stands upright. One answer for all of it.
// - The void, in a scene that no light enters from outside: more than half of what is around a point is nothing.
//
// is_dark   by place
// reach_m   as near as places are joined
// returns   by place
std::vector<uint8_t> findUnseenDark(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                    std::vector<uint8_t> is_dark, double reach_m);

}  // namespace nlg
