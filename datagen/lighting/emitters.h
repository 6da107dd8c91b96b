// The shining triangles of a scene, chosen one at a time by how much light each may send to a place.
//
// They are gathered into clusters of neighbours. A place draws a cluster by power over squared distance, without asking what
// stands between, and a triangle of it by area times luminance.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/scene/scene.h"

namespace nlg {

class Random;

// A point on a shining triangle.
struct EmitterPoint {
  uint32_t triangle = 0;
  glm::vec3 position{0.0f};
  float area_density = 0.0f;  // of drawing it from that place, per square metre
};

class Emitters {
 public:
  // The scene must outlive it.
  explicit Emitters(const Scene& scene);

  bool empty() const { return clusters_.empty(); }
  // Not when empty.
  EmitterPoint draw(const glm::vec3& from, Random& random) const;
  // Of a point of this triangle, as draw would give it from there; 0 for a triangle that does not shine.
  float areaDensity(uint32_t triangle, const glm::vec3& from) const;

 private:
  struct Cluster {
    glm::vec3 middle{0.0f};
    float radius_squared = 0.0f;
    float power = 0.0f;             // area times luminance
    uint32_t first = 0, count = 0;  // of its triangles
  };
  static float reach(const Cluster& cluster, const glm::vec3& from);
  float luminance(uint32_t triangle) const;

  const Scene& scene_;
  std::vector<uint32_t> triangles_;  // by cluster
  std::vector<float> sums_;          // of power within the cluster, running
  std::vector<Cluster> clusters_;
  std::vector<uint32_t> cluster_of_;  // by triangle of the scene; 0xffffffff for those that do not shine; empty without emitters
};

}  // namespace nlg
