// Whether a level's light is whole: what its surfaces, lamps, suns, sky and emission send to a surface, against the light that the
// level's own compiler left there.
//
// Both are light as BakedLight has it: irradiance over pi. They differ where compilers do as physics does not (weaker bounces,
// ambient light, dirt), and by every lamp that the level's file no longer holds.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace nlg {

struct ClosureOptions {
  int places = 1000;       // at most, spread by area over triangles that have a lightmap
  int rays = 512;          // of a place and part; >= 8
  double before_m = 0.02;  // distance of a place from its surface
};

struct ClosurePlace {
  glm::vec3 position{0.0f};  // relative to the scene's origin
  glm::vec3 normal{0.0f};
  glm::vec3 baked{0.0f};  // what the compiler left
  // what arrives, by where from: baked light of other surfaces, what shines, sky, lamps, suns
  glm::vec3 surfaces{0.0f}, emission{0.0f}, sky{0.0f}, lamps{0.0f}, suns{0.0f};

  glm::vec3 predicted(const glm::vec3& ambient) const { return surfaces + emission + sky + lamps + suns + ambient; }
};

struct Closure {
  std::vector<ClosurePlace> places;
  uint32_t in_solid = 0;     // places left out: the level's faces go on inside its walls
  double correlation = 0.0;  // of luminances; 0 with fewer than two places
  double scale = 0.0;        // baked = scale * predicted, by least squares of luminances
};

// scene   with lightmaps; otherwise no place is found. A pure function of scene, options and seed.
Closure measureClosure(const Scene& scene, const ClosureOptions& options, uint64_t seed);

}  // namespace nlg
