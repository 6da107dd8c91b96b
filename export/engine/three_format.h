// three.js: light.bin, the texture of a LightProbeGrid (0.187) as it is, texels of sh_texture.h without a header.
//
// Its shader moves every position by half a texel along the normal, and shows nothing where that leaves the box by more than a
// hundredth of a texel (examples/jsm/tsl/lighting/LightProbeGridNode.js; ShaderChunk/lightprobes_pars_fragment.glsl.js).
#pragma once

#include "export/engine/engine_format.h"

namespace nlg {

std::vector<EngineFile> threeFiles(const LightVolume& volume);
EngineIrradiance readThree(const std::vector<EngineFile>& files, const LightBox& box);

}  // namespace nlg
