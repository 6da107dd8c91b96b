// three.js, per pixel: grid.bin and look_up.glsl, as `nlg-export shader` writes them, and the modules that light materials by them.
// Nothing is resampled.
#pragma once

#include <string_view>

#include "export/engine/engine_format.h"
#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

// three_light_grid.js, of WebGLRenderer; three_light_grid_webgpu.js, of WebGPURenderer
extern const std::string_view kThreeLightGridText, kThreeLightGridWebgpuText;

// grid       one that checkLightGrid accepts
// returns    that of packShaderGrid; *files is empty where it is not ok
FileResult threePerPixelFiles(const LightGrid& grid, std::vector<EngineFile>* files);

}  // namespace nlg
