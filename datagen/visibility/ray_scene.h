// Ray queries on a scene, by Embree. Only this code uses Embree.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/scene.h"

namespace nlg {

enum class Facing : uint8_t { nothing, front, back, both };  // both: a double-sided material, or faces that coincide

// Where a ray of light ends, or meets a transmissive surface.
struct LightHit {
  enum class Kind : uint8_t { nothing, sky, surface };
  Kind kind = Kind::nothing;
  bool is_front = true;      // of a surface: the ray meets its front
  uint32_t triangle = 0;     // of a surface: index into the scene's triangles; of sky: into its sky faces'
  float distance = 0.0f;     // in lengths of the ray's direction
  float u = 0.0f, v = 0.0f;  // weights of the triangle's second and third corner
  glm::vec3 normal{0.0f};    // unit, of the side that the ray meets
};

class AirRegions;

class RayScene {
 public:
  // Copies what it needs of the scene. Sky faces end rays of light (lightHit) and no others; transmissive surfaces end none of
  // these, and those that are thin no others either: whatever says "surface" or "triangle" below means all but thin transmissive
  // ones, and for light all but transmissive ones. throws std::bad_alloc when there is no memory; InputError when Embree cannot
  // build
  explicit RayScene(const Scene& scene);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  // Which side of the first face a ray from origin meets. A front and a back in one place (within 2^-18 of the way) say `both`,
  // whichever of them the traversal finds first.
  Facing firstFacing(const glm::vec3& origin, const glm::vec3& direction) const;

  bool hasSkyFaces() const;
  // The same with sky faces among the faces: their backs are where the scene ends.
  Facing firstFacingWithSky(const glm::vec3& origin, const glm::vec3& direction) const;
  // The same for whom backs alone count: what it calls front may be `both`, which saves a second search.
  Facing firstBackWithSky(const glm::vec3& origin, const glm::vec3& direction) const;

  // The first surface, or front of a sky face, that a ray of light meets; of faces in the same place one that looks towards it. Sky
  // faces let rays through from behind, and transmissive surfaces are not looked at.
  LightHit lightHit(const glm::vec3& origin, const glm::vec3& direction) const;

  bool hasTransmissive() const;
  // The first transmissive surface beyond `near` and before `far`, both in lengths of the direction; Kind::nothing without one.
  // To go on behind it: near = justBehind(hit).
  LightHit transmissiveHit(const glm::vec3& origin, const glm::vec3& direction, float near, float far) const;
  static float justBehind(const LightHit& hit);

  // Whether a surface stands between two places, themselves included. Edges are watertight (Embree's robust mode): what passes through a
  // shared edge meets at least one of its triangles. What runs in a triangle's plane does not meet it.
  bool isBlocked(const glm::vec3& from, const glm::vec3& to) const;

  // The same of what stops light wholly: transmissive surfaces do not count.
  bool isOpaqueBetween(const glm::vec3& from, const glm::vec3& to) const;
  // The same of all that lies this way; sky faces do not count.
  bool isOpaqueAlong(const glm::vec3& from, const glm::vec3& direction) const;

  // Whether light that leaves `from` is stopped before `to`: by a surface, or by a sky face that it meets from the front.
  bool isLightBlocked(const glm::vec3& from, const glm::vec3& to) const;

  // Whether a sky face touches the axis-aligned cube around center, or perhaps only comes near.
  bool isSkyNearCube(const glm::vec3& center, float half_side) const;

  // The scene's cavity_m: how wide air is that somebody can be in. 0: all is.
  double cavityWidth() const;
  // Whether no surface that stops light is closer to a place than this.
  bool isFree(const glm::vec3& center, float radius) const;
  // How far the nearest one is; `most` where it is farther.
  float clearance(const glm::vec3& center, float most) const;
  // By how wide air is. The scene's cavity_m is above 0.
  const AirRegions& airRegions() const;

  // Every triangle that touches the axis-aligned cube around center, rising, and perhaps some that only come near.
  void trianglesNearCube(const glm::vec3& center, float half_side, std::vector<uint32_t>* triangles) const;

  const std::vector<glm::vec3>& positions() const;
  const std::vector<glm::uvec3>& triangles() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nlg
