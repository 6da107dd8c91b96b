// Classifies a scene's transmissive materials as thin or dense, by the mean light that they let through.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/scene.h"

namespace nlg {

// A transmissive surface that stops at least this share of light is dense: a sheet to weighting functions. One that stops less is
// air to them.
inline constexpr double kDenseTransmissive = 0.5;

// Judges every material that may be transmissive: thin or dense by the mean, over its area in the scene, of what does not go
// through. One that stops all but half a hundredth is opaque: programs write that materials blend where they do not. A
// transmissive one becomes double_sided.
//
// scene               with its images
// names               of the materials, for the note; where one is empty or missing, its number
// dense_transmissive  0 … 1.01
// returns             one line that names the transmissive materials, or none
std::vector<std::string> judgeTransmissive(Scene& scene, const std::vector<std::string>& names, double dense_transmissive);

// Means of what surfaces look like, over all of a material's area in a scene.
//
// By material the mean of at(triangle, u, v), u and v as surface_look.h has them, at points that fill each triangle evenly.
// is_wanted   by material: of all others the mean is not taken
// returns     (mean, area in m²); zeros where a material is not wanted, or has no area
std::vector<glm::dvec4> meansOfMaterials(const Scene& scene, const std::vector<bool>& is_wanted,
                                         const std::function<glm::dvec3(uint32_t triangle, float u, float v)>& at);

}  // namespace nlg
