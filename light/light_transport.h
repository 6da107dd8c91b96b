// Path tracer: light that arrives at points of a scene, for probes and for ground truth.
//
// Surfaces are diffuse. Where the level's own compiler left light on them (SceneLight::baked) one ray holds all bounces: what it
// meets shines with that light times the base colour, and with its own emission. Elsewhere paths are traced: next-event
// estimation at every vertex to lamps, suns and shining triangles (these by multiple importance sampling), Russian roulette.
// Lamps and suns are sampled at the place itself in both. Sky is met where a ray leaves the scene, or by a front of SkyFaces.
// Colour, emission and what a transmissive surface lets through are those of the point that a ray meets
// (scene/model/surface_look.h). A path that meets a transmissive surface goes on through it or back from it, by chance; a ray to
// a light is dimmed by each of them on its way.
//
// Directions are low-discrepancy; every number is a pure function of the scene, the options and the seed of the place, the same
// on any number of threads. Any number of threads may ask at once.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "datagen/visibility/ray_scene.h"
#include "nlg/light_grid.h"
#include "scene/model/scene.h"

namespace nlg {

// Coefficients of arriving radiance (nlg/light_grid.h), red, green, blue each.
using LightSh = std::array<glm::vec3, kShCount>;

glm::vec3 irradiance(const LightSh& light, const glm::vec3& normal);

// What a look-up returns of it: flooredIrradiance (nlg/light_grid.h).
glm::vec3 flooredIrradiance(const LightSh& light, const glm::vec3& normal);

// By group of lights (LightGroups): what each gives adds up to the whole. Beyond the scene's groups all are 0.
using GroupedLight = std::array<glm::vec3, kMaxLightGroups>;

class DirectionGuide;
class SurfaceCache;

// Which light of lamps and suns counts at the place itself. What they send to surfaces, and those send on, always does: an engine
// that draws its sun or its lamps with shadow maps takes only that from a light grid. `reflected` leaves out what shining surfaces
// send straight, too: an engine draws them as lamps. The sky's light always counts.
enum class DirectLight : uint8_t { all, no_suns, none, reflected };
// throws   UsageError on a name that is none of "all", "no_suns", "none", "reflected"
DirectLight directLightFromName(const std::string& name);

struct GatherOptions {
  int rays = 1024;       // first directions of a place; >= 8
  int max_bounces = 64;  // of a path behind its first hit; Russian roulette ends most of them after a few. 0: direct light alone
  const SurfaceCache* cache = nullptr;  // ends paths where it knows what arrives (surface_cache.h); null: they go on
  DirectLight direct = DirectLight::all;
};

// Where a ray met a surface; without a normal: it met none.
struct SurfacePoint {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};  // of the side that it met
  // What comes back along the ray, over pi, of the irradiance there: the surface's albedo, times what transmissive surfaces
  // before it let through.
  glm::vec3 reflectance{0.0f};

  bool isSurface() const { return normal != glm::vec3(0.0f); }
};

struct GatheredLight {
  LightSh light{};
  LightSh deviation{};          // standard deviation of each coefficient: of the mean over 8 sets of directions
  std::vector<LightSh> groups;  // of scenes whose lights have groups: what each of them gives
};

// One direction that light arrives from, and what it adds to the integral over all directions: radiance times solid angle.
struct ArrivingLight {
  glm::vec3 direction{0.0f};  // unit
  glm::vec3 flux{0.0f};
};

struct GatheredIrradiance {
  glm::vec3 irradiance{0.0f};
  glm::vec3 deviation{0.0f};  // as above
  GroupedLight groups{};      // what each gives of the irradiance
};

class LightTransport {
 public:
  // Both must outlive this object. rays has the scene's triangles and its sky's.
  LightTransport(const Scene& scene, const RayScene& rays);
  ~LightTransport();

  // What arrives at a place from all sides.
  // position_m   relative to the scene's origin, in air
  // index        of the place among those of one seed: what follow one another send rays into each other's gaps, so that their
  //              mean is less noisy than that of places with seeds of their own
  // guide        of the places before this one, where there are any; learns from it
  GatheredLight gather(const glm::dvec3& position_m, const GatherOptions& options, uint64_t seed, uint64_t index = 0,
                       DirectionGuide* guide = nullptr) const;

  // The same, direction by direction: for whoever stores light in a form of its own.
  std::vector<ArrivingLight> arriving(const glm::dvec3& position_m, const GatherOptions& options, uint64_t seed) const;

  // What arrives on a small plane: exact for its normal, without harmonics. Ground truth of a place.
  // hits   receives where each ray ended, when given; of rays that carry the same share of a cosine over all directions
  GatheredIrradiance gatherIrradiance(const glm::dvec3& position_m, const glm::vec3& normal, const GatherOptions& options,
                                      uint64_t seed, std::vector<SurfacePoint>* hits = nullptr) const;

  // What a camera sees along a ray, lamps and suns not among it: one path.
  glm::vec3 radianceAlong(const glm::vec3& origin, const glm::vec3& direction, int max_bounces, uint64_t seed) const;

  // Radiance that a surface point sends back, its own shine not among it: one path.
  GroupedLight reflected(const SurfacePoint& point, uint64_t seed) const;

  // How far off a surface rays begin, metres, so that they do not meet it again.
  float nudge() const;
  // The share of light that a surface sends back at a point, by channel; of a transmissive surface's point, too.
  glm::vec3 albedo(const LightHit& hit) const;
  // Radiance that it sends by itself towards the side that the ray came from.
  glm::vec3 emission(const LightHit& hit) const;
  const Scene& scene() const;
  const RayScene& rays() const;
  // Whether a ray's first hit holds all bounces.
  bool isBaked() const;
  size_t groupCount() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nlg
