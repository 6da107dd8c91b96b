// Tests where suns shine.
#pragma once

#include <vector>

#include "datagen/visibility/ray_scene.h"
#include "scene/model/scene.h"
#include "scene/model/scene_light.h"
#include "scene/model/sky_image.h"

namespace nlg {

// Whether suns and sky send light this way, transmissive surfaces apart: what it meets first is nothing, or a sky face that does
// not shine by itself.
// from   relative to the scene's origin
bool comesFromOpenSky(const Scene& scene, const RayScene& rays, const glm::vec3& from, const glm::vec3& direction);

// Whether the middle of any sun is seen from a place and stands before its plane; transmissive surfaces do not count.
// position_m   relative to the scene's origin
bool isInSunlight(const Scene& scene, const RayScene& rays, const glm::dvec3& position_m, const glm::vec3& normal);

// Directions towards the bright parts of a sky's image, drawn by luminance times solid angle.
class SkySampler {
 public:
  // image   must outlive it; an empty one, or a black one, has nothing to draw
  explicit SkySampler(const SkyImage& image);

  bool empty() const { return row_sums_.empty(); }

  struct Drawn {
    glm::vec3 direction{0.0f};  // unit
    glm::vec3 radiance{0.0f};
  };
  // Not of an empty one. u, v   in [0, 1); evenly spread pairs give evenly spread directions
  Drawn draw(double u, double v) const;
  // Of drawing a direction of that radiance, per steradian.
  float density(const glm::vec3& radiance) const { return luminance(radiance) * per_power_; }

 private:
  const SkyImage& image_;
  std::vector<double> row_sums_;    // of luminance times solid angle, running, over all of it
  std::vector<float> column_sums_;  // by row: the same within it
  float per_power_ = 0.0f;
};

}  // namespace nlg
