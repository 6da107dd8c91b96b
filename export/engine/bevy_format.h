// Bevy: light.ktx2, the voxels of an IrradianceVolume, a texture of ambient_cubes.h.
#pragma once

#include "export/engine/engine_format.h"

namespace nlg {

std::vector<EngineFile> bevyFiles(const LightVolume& volume);
EngineIrradiance readBevy(const std::vector<EngineFile>& files, const LightBox& box);

}  // namespace nlg
