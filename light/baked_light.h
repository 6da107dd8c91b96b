// Looks up light that a level's compiler stored on a surface (lightmaps, vertex light).
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace nlg {

// Light on a triangle at the weights u and v of its second and third corner; bilinear between texels, whose centres stand at
// halves. What leaves the surface is this times its base colour.
//
// scene   with baked light
glm::vec3 bakedLight(const Scene& scene, uint32_t triangle, float u, float v);

}  // namespace nlg
