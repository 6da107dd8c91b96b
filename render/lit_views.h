// Views that show the most of what a method lights, for pages that open at the first of them.
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "datagen/probes/probe_placement.h"
#include "light/methods/light_method.h"
#include "render/camera.h"

namespace nlg {

struct LitViewOptions {
  double fov_y = 1.0472, aspect = 16.0 / 9.0;
  uint64_t seed = 1;
  int thread_count = 1;
};

// Eyes are where a player's are (light/standing.h): where a figure has room, else where one crouches, else anywhere in air. Of twelve
// directions around each, the lit area that is seen decides: light counts up to the scene's usual, what is further away more, many
// sides of things more than a bare wall, what is right before the eye and backs of faces against the view. The same for the same scene, light and seed.
class LitViews {
 public:
  // extent   what a bake lights, relative to the scene's origin
  LitViews(const LightTransport& transport, const LightAt& light_at, const ExtentBox& extent, const LitViewOptions& options);

  // Any camera on the same scale: how much it shows that no view before does; above 0 where it shows light.
  double worthOf(const Camera& camera) const;

  // The worth of the best that is left; 0 of none.
  double bestWorth() const;

  // Takes the best that is left. What it shows counts little from then on.
  // throws   InputError when no point in air was found
  Camera takeBest();

  // Of a camera that is shown besides.
  void take(const Camera& camera) { markSeen(pointsOf(camera)); }

 private:
  struct Point {
    glm::vec3 at{0.0f};
    float light = 0.0f;   // irradiance's luminance; below 0: the back of a face
    float weight = 0.0f;  // by distance: below 0 right before the eye
    uint32_t side = 0;    // material and direction: a wall is one, however many triangles it has
  };
  struct Candidate {
    Camera camera;
    std::vector<Point> points;
  };

  std::vector<Point> pointsOf(const Camera& camera) const;
  double worthOf(const std::vector<Point>& points) const;
  void markSeen(const std::vector<Point>& points);
  uint64_t cellOf(const Point& point) const;
  const Candidate* best() const;

  const LightTransport& transport_;
  const LightAt light_at_;
  const LitViewOptions options_;
  double near_m_ = 0.5, cell_m_ = 0.5;
  double usual_light_ = 0.0;
  std::vector<Candidate> candidates_;
  std::unordered_set<uint64_t> seen_;  // cells of the scene
};

}  // namespace nlg
