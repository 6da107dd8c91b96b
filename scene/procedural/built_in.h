// Shared parts of the small built-in scenes for light (procedural.h): cameras, panels, and the rooms beside daylight.
#pragma once

#include <string>

#include "scene/procedural/mesh_builder.h"
#include "scene/scene.h"

namespace nlg {

// A panel 2 cm thick under a ceiling, which shines downward.
// middle   of its upper side; half: of its sides along x and z
void addPanel(MeshBuilder& mesh, const glm::dvec3& middle, const glm::dvec2& half, uint32_t housing, uint32_t lamp);

// A camera in world coordinates.
void addCamera(Scene& scene, const std::string& name, const glm::dvec3& eye, const glm::dvec3& look, double fov_degrees);

// Rooms beside daylight, each seed another kind of place (procedural.h names them).
inline constexpr uint64_t kDaylightSeeds = 26;
Scene makeDaylight(uint64_t seed);  // seed < kDaylightSeeds

}  // namespace nlg
