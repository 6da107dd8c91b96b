#include "export/engine/engine_format.h"

#include <nlohmann/json.hpp>

#include "export/engine/ktx2_file.h"
#include "export/engine/sh_texture.h"
#include "export/shader/shader_export.h"
#include "runtime_eval/shader_grid/nlg_light_grid.h"

namespace nlg {
namespace {

EngineFile threeFile(const LightBox& /*box*/, const std::string& texels) { return {"light.bin", texels}; }

EngineIrradiance threeIrradiance(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    PositionM moved_m;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double texel_m = (box.high_m[axis] - box.low_m[axis]) / box.texel_count[axis], margin_m = 0.01 * texel_m;
      moved_m[axis] = position_m[axis] + 0.5 * texel_m * normal_3[axis];
      if (!(moved_m[axis] >= box.low_m[axis] - margin_m && moved_m[axis] <= box.high_m[axis] + margin_m))
        return std::array<float, kShChannels>{};
    }
    return shTextureIrradiance(texture, box, moved_m, normal_3);
  };
}

template <class Three>
std::string spaced(const Three& three) {
  std::string text;
  for (const auto& number : three) text += (text.empty() ? "" : " ") + nlohmann::json(number).dump();
  return text;
}

EngineFile ktx2File(const LightBox& box, const std::string& texels) {
  return {"light.ktx2", ktx2Bytes(shTextureSize(box.texel_count), texels,
                                  {{"KTXwriter", "nlg-export engine"},
                                   {"nlg.low_m", spaced(box.low_m)},
                                   {"nlg.high_m", spaced(box.high_m)},
                                   {"nlg.resolution", spaced(box.texel_count)}})};
}

EngineIrradiance pixelIrradiance(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    return shTextureIrradiance(texture, box, position_m, normal_3);
  };
}

std::vector<EngineFile> threeModules(const ShaderGrid& grid) {
  return {{"look_up.glsl", shaderText(grid)},
          {"three_light_grid.js", std::string(kThreeLightGridText)},
          {"three_light_grid_webgpu.js", std::string(kThreeLightGridWebgpuText)}};
}

std::vector<EngineFile> cHeader(const ShaderGrid& /*grid*/) { return {{"nlg_light_grid.h", std::string(kCHeaderText)}}; }

}  // namespace

const std::vector<TextureFormat>& textureFormats() {
  static const std::vector<TextureFormat> formats = {{"three", threeFile, threeIrradiance},
                                                     {"ktx2-sh", ktx2File, pixelIrradiance}};
  return formats;
}

const std::vector<GridFormat>& gridFormats() {
  static const std::vector<GridFormat> formats = {{"three-per-pixel", threeModules}, {"c-header", cHeader}};
  return formats;
}

std::vector<EngineFile> gridFiles(const GridFormat& format, const ShaderGrid& grid) {
  std::vector<EngineFile> files = format.look_up(grid);
  files.insert(files.begin(), {"grid.bin", shaderGridBytes(grid)});
  return files;
}

EngineIrradiance gridIrradiance(std::string bytes) {
  return [bytes = std::move(bytes)](const PositionM& position_m, const float* normal_3) {
    const NlgGrid grid = {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
    const float position[3] = {static_cast<float>(position_m[0]), static_cast<float>(position_m[1]),
                               static_cast<float>(position_m[2])};
    std::array<float, kShChannels> rgb;
    nlgIrradiance(&grid, position, normal_3, rgb.data());
    return rgb;
  };
}

}  // namespace nlg
