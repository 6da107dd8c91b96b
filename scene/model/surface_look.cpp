#include "scene/model/surface_look.h"

namespace nlg {
namespace {

template <class Value>
Value between(const std::vector<Value>& of_vertex, const glm::uvec3& t, float u, float v) {
  // from the first corner: of equal values exactly the value
  return of_vertex[t.x] + u * (of_vertex[t.y] - of_vertex[t.x]) + v * (of_vertex[t.z] - of_vertex[t.x]);
}

glm::vec4 imageAt(const Scene& scene, const TextureUse& use, const std::vector<glm::vec2>& places, uint32_t triangle, float u,
                  float v) {
  return texelAt(scene.images[static_cast<size_t>(use.image)], use, between(places, scene.triangles[triangle], u, v));
}

// Base colour and opacity.
glm::vec4 baseAt(const Scene& scene, const Material& material, uint32_t triangle, float u, float v) {
  glm::vec4 base(material.base_color, material.opacity);
  if (material.base_image.isThere()) base *= imageAt(scene, material.base_image, scene.base_places, triangle, u, v);
  if (!scene.vertex_colours.empty()) base *= between(scene.vertex_colours, scene.triangles[triangle], u, v);
  return base;
}

float transmissionAt(const Scene& scene, const Material& material, uint32_t triangle, float u, float v) {
  if (!(material.transmission > 0.0f) || !material.transmission_image.isThere()) return material.transmission;
  return material.transmission * imageAt(scene, material.transmission_image, scene.base_places, triangle, u, v).r;
}

}  // namespace

const Material& materialOf(const Scene& scene, uint32_t triangle) { return scene.materials[scene.triangle_material[triangle]]; }

glm::vec3 albedoOf(const Material& material, const glm::vec3& base_colour) {
  return glm::clamp(base_colour, glm::vec3(0.0f), glm::vec3(material.base_image.isThere() ? kWhitestTexel : kWhitestFactor));
}

glm::vec3 baseColourAt(const Scene& scene, uint32_t triangle, float u, float v) {
  return glm::vec3(baseAt(scene, materialOf(scene, triangle), triangle, u, v));
}

glm::vec3 emissionAt(const Scene& scene, uint32_t triangle, float u, float v) {
  const Material& material = materialOf(scene, triangle);
  glm::vec3 emission = material.emissive;
  if (emission == glm::vec3(0.0f)) return emission;
  if (material.emissive_image.isThere())
    emission *= glm::vec3(imageAt(scene, material.emissive_image, scene.emissive_places, triangle, u, v));
  // where a cut-out has a hole nothing shines
  if (material.transmissive != Transmissive::none) emission *= baseAt(scene, material, triangle, u, v).a;
  return emission;
}

TransmissiveLook transmissiveAt(const Scene& scene, uint32_t triangle, float u, float v) {
  const Material& material = materialOf(scene, triangle);
  const glm::vec4 base = baseAt(scene, material, triangle, u, v);
  const glm::vec3 colour(base);
  const float transmission = transmissionAt(scene, material, triangle, u, v);
  const float opacity = glm::clamp(base.a, 0.0f, 1.0f);
  return {glm::vec3(1.0f - opacity) + opacity * transmission * colour, opacity * (1.0f - transmission) * colour};
}

float stoppedAt(const Scene& scene, uint32_t triangle, float u, float v) {
  const Material& material = materialOf(scene, triangle);
  const float opacity = glm::clamp(baseAt(scene, material, triangle, u, v).a, 0.0f, 1.0f);
  return opacity * (1.0f - transmissionAt(scene, material, triangle, u, v));
}

}  // namespace nlg
