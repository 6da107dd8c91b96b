// Samples the emissive triangles of a scene by the light that each may send to a point.
//
// A triangle that shines by an image is cut into patches, each with the mean luminance of its part of the image; any other is one
// patch. Patches are gathered into clusters of neighbours. A place draws a cluster by power over squared distance, without asking what
// stands between, and a patch of it by area times luminance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/scene.h"

namespace nlg {

class Random;

// A point on a shining triangle.
struct EmitterPoint {
  uint32_t triangle = 0;
  glm::vec3 position{0.0f};
  float u = 0.0f, v = 0.0f;   // weights of the triangle's second and third corner
  float area_density = 0.0f;  // of drawing it from that place, per square metre
};

class Emitters {
 public:
  static constexpr size_t kMostClusters = 64;  // a place weighs them all: about as long as a ray takes
  static constexpr int kMostSide = 256;        // a triangle is cut into at most as many patches along a side

  // The scene must outlive it.
  explicit Emitters(const Scene& scene);

  bool empty() const { return clusters_.empty(); }

  // What one place draws from.
  class Draws {
   public:
    Draws(const Emitters& emitters, const glm::vec3& from);
    // Not without emitters. u   in [0, 1), of the cluster and its patch: evenly spread ones draw evenly among neighbours
    EmitterPoint draw(double u, Random& random) const;
    // Of a point of this triangle, as draw would give it; 0 where it does not shine.
    float areaDensity(uint32_t triangle, float u, float v) const;

   private:
    float density(size_t cluster, float luminance) const;  // of a patch of it
    float chance(size_t cluster) const;

    const Emitters& emitters_;
    std::array<float, kMostClusters> sums_;  // of the clusters' reach, running
  };

 private:
  // One of side² equal parts of a triangle; `part` counts them along rows of u, each in turn upright and upside down.
  struct Patch {
    uint32_t triangle = 0;
    uint16_t side = 1, part = 0;
    float luminance = 0.0f;  // mean over it
  };
  struct Shining {
    uint32_t first_part = 0;  // into patch_at_
    uint16_t side = 1;
  };
  struct Cluster {
    glm::vec3 middle{0.0f};
    float radius_squared = 0.0f;
    float power = 0.0f;             // area times luminance
    uint32_t first = 0, count = 0;  // of its patches
  };
  static float reach(const Cluster& cluster, const glm::vec3& from);
  void cutIntoPatches();

  const Scene& scene_;
  std::vector<Patch> patches_;  // by cluster
  std::vector<float> sums_;     // of power within the cluster, running
  std::vector<Cluster> clusters_;
  std::vector<uint32_t> cluster_of_;  // by patch
  std::vector<uint32_t> shining_of_;  // by triangle of the scene, into shining_; 0xffffffff for those that do not shine; empty
                                      // without emitters
  std::vector<Shining> shining_;      // triangles that shine
  std::vector<uint32_t> patch_at_;    // by these and part: the patch; 0xffffffff for a part that is dark
};

// Light that a level's compiler stored (lightmaps, vertex light) on a triangle at the weights u and v of its second and third corner; bilinear between texels, whose centres stand at
// halves. What leaves the surface is this times its base colour.
//
// scene   with baked light
glm::vec3 bakedLight(const Scene& scene, uint32_t triangle, float u, float v);

}  // namespace nlg
