// Chooses views of a scene for comparisons with truth: the same for all methods, spacings and options of a bake.
//
// Eyes are where a player's are: 1.6 m above a floor on which a figure has room in the air, so that none stand in the hollow of a wall. In
// a scene that has no such floor they are 20 cm below the ceiling, where one crouches. Every
// room (validate/light/rooms.h) has a view or more, those under a roof before outdoors, and dark ones last. Each looks where there is
// much to see (render/camera.h), and of a room's views those are taken that show the most that is lit. In most views stands a figure,
// three balls one above another, near the middle of the room: what moves through it is lit like these.
#pragma once

#include <cstdint>
#include <vector>

#include "light/standing.h"
#include "render/camera.h"
#include "render/sight.h"

namespace nlg {

struct SceneViewOptions {
  int width = 64, height = 36;  // pixels: their quotient decides where there is much to see
  double fov_y = 1.05;          // radians
  int views_per_room = 1;
  int most_views = 5;  // lit rooms first, those under a roof before others, of both those that show the most lit surface
  uint64_t places_in_air = 2000;  // of which rooms are made
  uint64_t seed = 1;
  int thread_count = 1;
};

inline constexpr size_t kLargestRooms = 3;  // lit, under a roof, that get a view more than the others
// Of the surface that the best of a room's views shows: where less is lit the room is dark. Lit is what gets more than an eye adapts to,
// kLeastLight (view_figures.h) of the median of the brightest view, or leastAdapted (render/tone.h).
inline constexpr double kLeastLitShare = 0.1;

struct SceneView {
  uint32_t room = 0;  // its number, in the order of most_views; of a camera its own
  Camera camera;
  std::vector<Ball> figure;  // from its foot to its head; none where the view shows no free place for it
  bool has_roof = false;
};

struct SceneViews {
  std::vector<SceneView> views;  // by room
  uint32_t rooms = 0;
  uint32_t rooms_without_floor = 0;  // where nobody can stand
  uint32_t rooms_dark = 0;           // of those with a floor: they come last
  uint32_t rooms_left_out = 0;       // by most_views
};

// All eyes and centres of balls are in air and in the extent. The same for the same scene, extent and options on any number of threads.
// extent   where places are drawn, relative to the scene's origin
SceneViews findViews(const LightTransport& transport, const ExtentBox& extent, const SceneViewOptions& options);

// What the scene's own cameras see, without figures.
SceneViews cameraViews(const LightTransport& transport);

}  // namespace nlg
