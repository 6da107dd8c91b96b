// The hull of a level: walls and sky that close off, on all sides, the space in which people are.
//
// What lies beyond it nobody visits: the land around a building, the outside of its walls. Geometry alone does not say which side is meant;
// the places do from which a scene is looked at (cameras, where players begin) and where its lamps are.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datagen/visibility/ray_scene.h"

namespace nlg {

class Hull {
 public:
  // There is a hull where there is a place, and rays from all of them meet a surface or the front of a sky face, but for one in 250:
  // cracks. A scene with a window onto nothing has none.
  // rays     must outlive this object
  // places   relative to the scene's origin
  Hull(const RayScene& rays, const std::vector<glm::vec3>& places);
  bool isThere() const { return is_there_; }

  // Whether none of 64 rays from a place, even in all directions, leaves the scene. A pure function; any number of threads may ask.
  bool holds(const glm::vec3& place) const;

 private:
  const RayScene& rays_;
  std::vector<glm::vec3> directions_;  // of holds
  bool is_there_;
};

}  // namespace nlg
