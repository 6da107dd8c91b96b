// What scene.h promises of every scene, held against one that was read from hostile bytes.
#pragma once

#include <cmath>
#include <string>

#include "scene/scene.h"
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
