// Scenes made of a few faces, for tests that know what must come out.
#pragma once

#include <initializer_list>

#include "tests/scene/built_scenes.h"

namespace nlg {

enum class Sides : uint32_t { one = 0, two = 1 };  // also the material's index

class SceneOfFaces {
 public:
  SceneOfFaces() {
    scene_.id = "by hand";
    scene_.materials.resize(2);
    scene_.materials[1].double_sided = true;
  }

  // Front side: where a, b, c run counter-clockwise.
  SceneOfFaces& addTriangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, Sides sides = Sides::one) {
    const auto first = static_cast<uint32_t>(scene_.positions.size());
    for (const glm::vec3& corner : {a, b, c}) scene_.positions.push_back(corner);
    scene_.triangles.push_back({first, first + 1, first + 2});
    scene_.triangle_material.push_back(static_cast<uint32_t>(sides));
    return *this;
  }

  SceneOfFaces& addQuad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
                        Sides sides = Sides::one) {
    return addTriangle(a, b, c, sides).addTriangle(a, c, d, sides);
  }

  // Faces look outward; a flipped box's look inward.
  SceneOfFaces& addBox(const glm::vec3& low, const glm::vec3& high, bool flipped = false) {
    for (const auto& [a, b, c, d] : boxSides(low, high)) flipped ? addQuad(a, d, c, b) : addQuad(a, b, c, d);
    return *this;
  }

  // A closed room: the inside of low..high is air, walls of this thickness are solid.
  SceneOfFaces& addRoom(const glm::vec3& low, const glm::vec3& high, float thickness) {
    return addBox(low, high, true).addBox(low - glm::vec3(thickness), high + glm::vec3(thickness));
  }

  Scene finish() const {
    Scene scene = scene_;
    scene.objects.push_back({"all", 0, static_cast<uint32_t>(scene.triangles.size()), false});
    return scene;
  }

 private:
  Scene scene_;
};

// The scene mirrored along the axes of `mirror` (bits as in SupportPattern), faces still looking where they looked.
inline Scene mirroredScene(Scene scene, int mirror) {
  for (glm::vec3& position : scene.positions) {
    for (int axis = 0; axis < 3; ++axis) position[axis] *= (mirror >> axis) & 1 ? -1.0f : 1.0f;
  }
  if (__builtin_popcount(static_cast<unsigned>(mirror)) % 2) {
    for (glm::uvec3& triangle : scene.triangles) std::swap(triangle.y, triangle.z);
  }
  return scene;
}

// A wall from x = 0.31 to 0.47 that is infinite as far as a support of spacing 1 can tell.
inline Scene infiniteWall() { return SceneOfFaces().addBox({0.31f, -50, -50}, {0.47f, 50, 50}).finish(); }

// The same wall, ending at y = 0.07: the upper half of the support is open.
inline Scene halfWall() { return SceneOfFaces().addBox({0.31f, -50, -50}, {0.47f, 0.07f, 50}).finish(); }

// A wall with a square window, as one closed solid of four beams that share whole edges.
inline Scene wallWithHole() {
  SceneOfFaces faces;
  faces.addBox({0.31f, -50, -50}, {0.47f, -0.23f, 50});
  faces.addBox({0.31f, 0.29f, -50}, {0.47f, 50, 50});
  faces.addBox({0.31f, -0.23f, -50}, {0.47f, 0.29f, -0.31f});
  faces.addBox({0.31f, -0.23f, 0.27f}, {0.47f, 0.29f, 50});
  return faces.finish();
}

// One sheet, seen from the probe's side, thinner than anything.
inline Scene thinWall(Sides sides) {
  return SceneOfFaces().addQuad({0.31f, -50, -50}, {0.31f, -50, 50}, {0.31f, 50, 50}, {0.31f, 50, -50}, sides).finish();
}

// Needles across the support, each a thousandth wide.
inline Scene slivers() {
  SceneOfFaces faces;
  for (int i = 0; i < 200; ++i) {
    const float y = -0.9f + 0.009f * static_cast<float>(i), x = 0.2f + 0.003f * static_cast<float>(i % 7);
    faces.addTriangle({x, y, -2}, {x + 0.0004f, y + 0.001f, 2}, {x, y + 0.001f, -2}, Sides::two);
  }
  return faces.finish();
}

// Two boxes that reach into each other, neither cut to the other.
inline Scene crossingBoxes() {
  return SceneOfFaces()
      .addBox({0.21f, -0.9f, -0.43f}, {0.47f, 0.33f, 0.31f})
      .addBox({-0.37f, -0.31f, 0.11f}, {0.83f, 0.07f, 0.57f})
      .finish();
}

// A crate with a sheet that stands on one of its edges: three faces meet there, and the sheet has no thickness.
inline Scene crateWithFin() {
  SceneOfFaces faces;
  faces.addBox({0.19f, -0.81f, -0.4f}, {0.71f, -0.13f, 0.4f});
  faces.addQuad({0.19f, -0.13f, -0.4f}, {0.19f, -0.13f, 0.4f}, {0.19f, 0.6f, 0.4f}, {0.19f, 0.6f, -0.4f});
  return faces.finish();
}

// Ground at y = height, looking up; nothing else.
inline Scene terrainSheet(float height, Sides sides) {
  return SceneOfFaces().addQuad({-50, height, -50}, {-50, height, 50}, {50, height, 50}, {50, height, -50}, sides).finish();
}

inline Scene room(const glm::vec3& albedo, const glm::vec3& emission) {
  Scene scene = SceneOfFaces().addRoom({-2, -1, -3}, {2, 1.5f, 3}, 0.2f).finish();
  scene.materials[0].base_color = albedo;
  scene.materials[0].emissive = emission;
  return scene;
}

}  // namespace nlg
