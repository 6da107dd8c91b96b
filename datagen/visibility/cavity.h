// Finds cavities: closed hollows of air that no room's air reaches.
//
// Walls that are modelled as two sheets, boxes under a stage, closed cupboards. Counted as air they would take light's places, and
// probes in them would hold the dark of a hollow against the room before its wall.
#pragma once

#include <glm/glm.hpp>

#include "datagen/visibility/ray_scene.h"

namespace nlg {

// Whether a place lies in a cavity: no chain of sight leads from it to air that is wide (the scene's cavity_m), where a ball of this
// diameter is free, nor to the sky or past everything. Transmissive surfaces are no obstacle. What sees each other is in a cavity
// together, or not: one place speaks for all that are connected to it. By regions of air (air_regions.h), and in gaps that are too
// narrow for these by random walks of sight, of which several must come out: a crack that one ray in thousands passes opens nothing
// (docs/theory/visibility.md). Solid is somebody else's question. A pure function of scene and place.
// position_m   relative to the scene's origin
bool isInCavity(const RayScene& rays, const glm::dvec3& position_m);

}  // namespace nlg
