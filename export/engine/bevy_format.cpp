#include "export/engine/bevy_format.h"

#include "export/engine/ambient_cubes.h"
#include "export/engine/ktx2_file.h"
#include "export/engine/light_place.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kTexture = "light.ktx2";

}  // namespace

std::vector<EngineFile> bevyFiles(const LightVolume& volume) {
  return {{kTexture, ktx2Bytes({Ktx2Format::rgb9e5, ambientCubesSize(volume.box.texel_count), packAmbientCubes(volume),
                                placeTexts(volume.box)})}};
}

EngineIrradiance readBevy(const std::vector<EngineFile>& files, const LightBox& box) {
  const Ktx2Texture file = parseKtx2(kTexture, fileNamed(files, kTexture));
  requireSize(kTexture, file.size, ambientCubesSize(box.texel_count));
  if (file.format != Ktx2Format::rgb9e5) throw InputError(kTexture, "vkFormat", "123", "97");
  return [texture = textureOfRgb9e5(file.texels, file.size), box](const PositionM& position_m, const float* normal_3) {
    return ambientCubesIrradiance(texture, box, position_m, normal_3);
  };
}

}  // namespace nlg
