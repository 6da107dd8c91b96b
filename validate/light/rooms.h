// Splits a scene's points in air into rooms, by what the points see.
//
// A room is told by sight, not by walls: places that see much the same within reach belong together, so that a hall is one room and
// what lies behind a window, a door ajar or a corner is another. Outdoors is a room, or several, like others.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datagen/visibility/ray_scene.h"

namespace nlg {

struct RoomOptions {
  double reach_m = 12.0;      // how far a place sees
  double least_alike = 0.4;   // of what either of two places sees, the share that both see: below it they lie in different rooms
  double left_share = 0.01;   // of places: rooms are looked for until no more than this is left
  size_t most_places = 2000;  // whose sight is compared, the first ones; all others join the rooms of those that they see
  int threads = 1;            // the same rooms for any number
};

struct SeenRoom {
  glm::dvec3 middle_m{0.0};      // one of its places, which sees most of the others from near
  std::vector<uint32_t> places;  // indices, rising
};

// The largest room first. No place is in two rooms; in none are those few that are left and see no place of any room.
// places_in_air   relative to the scene's origin
std::vector<SeenRoom> findRooms(const RayScene& rays, const std::vector<glm::dvec3>& places_in_air, const RoomOptions& options);

// By place: its room's number, or rooms.size() in none.
std::vector<uint32_t> roomOfPlaces(const std::vector<SeenRoom>& rooms, size_t place_count);

}  // namespace nlg
