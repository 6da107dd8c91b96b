// The shining triangles of a scene, chosen one at a time by how much light each may send to a place.
//
// They are gathered into clusters of neighbours. A place draws a cluster by power over squared distance, without asking what
// stands between, and a triangle of it by area times luminance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/scene.h"

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
  static constexpr size_t kMostClusters = 64;  // a place weighs them all: about as long as a ray takes

  // The scene must outlive it.
  explicit Emitters(const Scene& scene);

  bool empty() const { return clusters_.empty(); }

  // What one place draws from.
  class Draws {
   public:
    Draws(const Emitters& emitters, const glm::vec3& from);
    // Not without emitters. u   in [0, 1), of the cluster: evenly spread ones draw evenly among neighbours
    EmitterPoint draw(double u, Random& random) const;
    // Of a point of this triangle, as draw would give it; 0 for a triangle that does not shine.
    float areaDensity(uint32_t triangle) const;

   private:
    float chance(size_t cluster) const;

    const Emitters& emitters_;
    std::array<float, kMostClusters> sums_;  // of the clusters' reach, running
  };

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
