// Tests whether a box is near a scene's triangles; thin transmissive surfaces count as air.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/model/scene.h"

namespace nlg {

// The scene must outlive it. Takes about 40 bytes a triangle.
class NearbyTriangles {
 public:
  NearbyTriangles(const Scene& scene);  // NOLINT(google-explicit-constructor): a scene of which one thing is asked is enough

  const Scene& scene() const { return scene_; }

  // True when a triangle is closer to the box than distance_m. Errs to one side only: what is closer is always found, but the
  // distance of a corner to a corner or an edge may be taken for less than it is. The same answer on every machine, whatever
  // order the triangles stand in. low_m <= high_m, relative to the scene's origin; distance_m >= 0
  bool anyCloser(const glm::dvec3& low_m, const glm::dvec3& high_m, double distance_m) const;

 private:
  struct Node {
    Bounds bounds;
    uint32_t first = 0;  // of its triangles in order_, or its first child; the second one follows it
    uint32_t count = 0;  // triangles; 0: an inner node
  };
  struct Range {
    uint32_t node_idx, first, count;
  };

  bool isCloser(const glm::uvec3& triangle, const glm::dvec3& centre, const glm::dvec3& half, double distance_m) const;
  void split(const Range& range, std::vector<Range>& open);

  const Scene& scene_;
  std::vector<uint32_t> order_;  // triangles
  std::vector<Node> nodes_;
};

}  // namespace nlg
