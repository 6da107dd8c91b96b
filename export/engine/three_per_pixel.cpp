#include "export/engine/three_per_pixel.h"

#include "export/shader/shader_export.h"

namespace nlg {

FileResult threePerPixelFiles(const LightGrid& grid, std::vector<EngineFile>* files) {
  files->clear();
  ShaderGrid packed;
  FileResult result = packShaderGrid(grid, &packed);
  if (!result.ok()) return result;
  *files = {{"grid.bin", shaderGridBytes(packed)},
            {"look_up.glsl", shaderText(packed)},
            {"three_light_grid.js", std::string(kThreeLightGridText)},
            {"three_light_grid_webgpu.js", std::string(kThreeLightGridWebgpuText)}};
  return result;
}

}  // namespace nlg
