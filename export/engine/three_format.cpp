#include "export/engine/three_format.h"

#include "export/engine/sh_texture.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kTexels = "light.bin";

}  // namespace

std::vector<EngineFile> threeFiles(const LightVolume& volume) { return {{kTexels, packShTexture(volume)}}; }

EngineIrradiance readThree(const std::vector<EngineFile>& files, const LightBox& box) {
  const std::string& texels = fileNamed(files, kTexels);
  const TextureSize size = shTextureSize(box.texel_count);
  if (texels.size() != 8 * texelsOf(size))
    throw InputError(kTexels, "its end", std::to_string(8 * texelsOf(size)) + " bytes", std::to_string(texels.size()));
  return [texture = textureOfHalves(texels, size), box](const PositionM& position_m, const float* normal_3) {
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

}  // namespace nlg
