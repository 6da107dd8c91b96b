// What scene.h promises of every scene, held against one that was read from hostile bytes.
#pragma once

#include <cmath>
#include <string>

#include "scene/model/scene.h"
#include "scene/model/surface_look.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {

inline void checkScene(const Scene& scene) {
  const auto finite = [](const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
  for (const glm::vec3& position : scene.positions) FUZZ_CHECK(finite(position), "positions");
  FUZZ_CHECK(scene.triangle_material.size() == scene.triangles.size(), "a material for each triangle");
  for (const glm::uvec3& t : scene.triangles)
    FUZZ_CHECK(t.x < scene.positions.size() && t.y < scene.positions.size() && t.z < scene.positions.size(), "corners");
  for (const uint32_t material : scene.triangle_material) FUZZ_CHECK(material < scene.materials.size(), "materials");
  for (const Material& material : scene.materials)
    FUZZ_CHECK(finite(material.base_color) && finite(material.emissive), "colours");
  const size_t vertex_count = scene.positions.size();
  const auto isOneEach = [&](const auto& values) { return values.empty() || values.size() == vertex_count; };
  FUZZ_CHECK(isOneEach(scene.base_places) && isOneEach(scene.emissive_places) && isOneEach(scene.vertex_colours), "vertices");
  for (const auto* places : {&scene.base_places, &scene.emissive_places}) {
    for (const glm::vec2& place : *places) FUZZ_CHECK(std::isfinite(place.x) && std::isfinite(place.y), "places");
  }
  for (const Material& material : scene.materials) {
    const bool has_base_places = scene.base_places.size() == vertex_count;
    FUZZ_CHECK(material.opacity >= 0.0f && material.opacity <= 1.0f, "opacity");
    FUZZ_CHECK(material.transmission >= 0.0f && material.transmission <= 1.0f, "transmission");
    FUZZ_CHECK(material.transmissive == Transmissive::none || material.double_sided, "a transmissive surface has two sides");
    for (const TextureUse* use : {&material.base_image, &material.emissive_image, &material.transmission_image})
      FUZZ_CHECK(use->image < static_cast<int>(scene.images.size()), "images");
    FUZZ_CHECK(has_base_places || !(material.base_image.isThere() || material.transmission_image.isThere()),
               "places on an image");
  }
  for (const TextureImage& image : scene.images)
    FUZZ_CHECK(image.texels.size() == static_cast<size_t>(image.width) * static_cast<size_t>(image.height), "texels");
  for (uint32_t i = 0; i < scene.triangles.size() && i < 64; ++i) {
    const TransmissiveLook look = transmissiveAt(scene, i, 0.3f, 0.4f);
    FUZZ_CHECK(finite(look.passes) && finite(look.reflects) && finite(emissionAt(scene, i, 0.3f, 0.4f)), "looks");
  }
  size_t first = 0;
  for (const SceneObject& object : scene.objects) {
    FUZZ_CHECK(object.first_triangle == first && object.triangle_count > 0, object.name);
    first += object.triangle_count;
  }
  FUZZ_CHECK(first == scene.triangles.size(), "objects cover all triangles");
  for (const Lamp& lamp : scene.light.lamps)
    FUZZ_CHECK(finite(lamp.position) && finite(lamp.intensity) && finite(lamp.direction), "lamps");
  for (const Sun& sun : scene.light.suns) FUZZ_CHECK(finite(sun.to_sun) && finite(sun.irradiance), "suns");
  for (const Viewpoint& eye : scene.viewpoints)
    FUZZ_CHECK(finite(eye.position) && finite(eye.forward) && finite(eye.up), eye.name);
  const BakedLight& baked = scene.light.baked;
  FUZZ_CHECK(baked.empty() || baked.triangle_page.size() == scene.triangles.size(), "a page for each triangle");
  FUZZ_CHECK(baked.empty() || baked.vertex_light.size() == scene.positions.size(), "light for each vertex");
  const uint64_t page_texels = uint64_t(baked.page_side) * baked.page_side;
  for (const int32_t page : baked.triangle_page)
    FUZZ_CHECK(page < 0 || (uint64_t(page) + 1) * page_texels <= baked.texels.size(), "pages");
  const SkyFaces& sky = scene.light.sky_faces;
  for (const glm::uvec3& t : sky.triangles)
    FUZZ_CHECK(t.x < sky.positions.size() && t.y < sky.positions.size() && t.z < sky.positions.size(), "corners of sky");
  FUZZ_CHECK(sky.shine.size() <= sky.triangles.size(), "shining faces");
  sceneBounds(scene);
  sceneLightSha256(scene);
}

}  // namespace nlg::fuzz
