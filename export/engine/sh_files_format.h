// KTX2 and DDS for everybody else: light.ktx2 or light.dds, a texture of sh_texture.h.
#pragma once

#include "export/engine/engine_format.h"

namespace nlg {

std::vector<EngineFile> ktx2ShFiles(const LightVolume& volume);
EngineIrradiance readKtx2Sh(const std::vector<EngineFile>& files, const LightBox& box);

std::vector<EngineFile> ddsShFiles(const LightVolume& volume);
EngineIrradiance readDdsSh(const std::vector<EngineFile>& files, const LightBox& box);

}  // namespace nlg
