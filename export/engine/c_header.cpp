#include "export/engine/c_header.h"

#include "export/shader/shader_export.h"
#include "runtime_eval/shader_grid/nlg_light_grid.h"

namespace nlg {
namespace {

const std::string kGrid = "grid.bin", kHeader = "nlg_light_grid.h";

}  // namespace

FileResult cHeaderFiles(const LightGrid& grid, std::vector<EngineFile>* files) {
  files->clear();
  ShaderGrid packed;
  FileResult result = packShaderGrid(grid, &packed);
  if (result.ok()) *files = {{kGrid, shaderGridBytes(packed)}, {kHeader, std::string(kCHeaderText)}};
  return result;
}

EngineIrradiance readCHeader(const std::vector<EngineFile>& files) {
  return [bytes = fileNamed(files, kGrid)](const PositionM& position_m, const float* normal_3) {
    const NlgGrid grid = {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
    const float position[3] = {static_cast<float>(position_m[0]), static_cast<float>(position_m[1]),
                               static_cast<float>(position_m[2])};
    std::array<float, kShChannels> rgb;
    nlgIrradiance(&grid, position, normal_3, rgb.data());
    return rgb;
  };
}

}  // namespace nlg
