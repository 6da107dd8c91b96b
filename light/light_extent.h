// The part of a scene that light fills. All boxes are relative to the scene's origin.
#pragma once

#include <string>
#include <vector>

#include "datagen/probes/probe_placement.h"
#include "scene/scene.h"

namespace nlg {

// The box around all triangles, those of the sky among them.
Bounds boundsWithSky(const Scene& scene);

// The extent of a setting, world, as probe placement takes it; where it names none, the scene's own or the box above.
ExtentBox lightExtent(const Scene& scene, const std::vector<std::string>& extent_m);

}  // namespace nlg
