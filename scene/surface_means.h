// Means of what surfaces look like, over all of a material's area in a scene.
#pragma once

#include <functional>
#include <vector>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace nlg {

// By material the mean of at(triangle, u, v), u and v as surface_look.h has them, at points that fill each triangle evenly.
// is_wanted   by material: of all others the mean is not taken
// returns     (mean, area in m²); zeros where a material is not wanted, or has no area
std::vector<glm::dvec4> meansOfMaterials(const Scene& scene, const std::vector<bool>& is_wanted,
                                         const std::function<glm::dvec3(uint32_t triangle, float u, float v)>& at);

}  // namespace nlg
