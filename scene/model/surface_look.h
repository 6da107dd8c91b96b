// The look of a point of a scene's surface: material factors times images and vertex colours.
//
// u and v are the weights of the triangle's second and third corner, as LightHit has them.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "scene/model/scene.h"

namespace nlg {

const Material& materialOf(const Scene& scene, uint32_t triangle);

// Of light that comes to a surface no more than this is sent back, by channel: files without images say 1 where they mean white
// paint, and light would never end. Images show what is there.
inline constexpr float kWhitestFactor = 0.9f, kWhitestTexel = 0.98f;
glm::vec3 albedoOf(const Material& material, const glm::vec3& base_colour);

// Linear; of a material without images and vertex colours exactly its factor.
glm::vec3 baseColourAt(const Scene& scene, uint32_t triangle, float u, float v);
// Radiance of the side that shines; of a transmissive surface, as much of it as its opacity.
glm::vec3 emissionAt(const Scene& scene, uint32_t triangle, float u, float v);

// What light meets at a point of a transmissive surface: a surface that lets some of it through.
struct TransmissiveLook {
  glm::vec3 passes{0.0f};    // of light that goes straight on
  glm::vec3 reflects{0.0f};  // of light that is scattered back, as a base colour
};
TransmissiveLook transmissiveAt(const Scene& scene, uint32_t triangle, float u, float v);
// The share of light that it lets nowhere through, whatever its colour.
float stoppedAt(const Scene& scene, uint32_t triangle, float u, float v);

}  // namespace nlg
