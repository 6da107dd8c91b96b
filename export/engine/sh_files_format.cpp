#include "export/engine/sh_files_format.h"

#include "export/engine/dds_file.h"
#include "export/engine/ktx2_file.h"
#include "export/engine/light_place.h"
#include "export/engine/sh_texture.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kKtx2 = "light.ktx2", kDds = "light.dds";

}  // namespace

std::vector<EngineFile> ktx2ShFiles(const LightVolume& volume) {
  return {{kKtx2, ktx2Bytes({Ktx2Format::rgba16f, shTextureSize(volume.box.texel_count), packShTexture(volume),
                             placeTexts(volume.box)})}};
}

EngineIrradiance readKtx2Sh(const std::vector<EngineFile>& files, const LightBox& box) {
  const Ktx2Texture file = parseKtx2(kKtx2, fileNamed(files, kKtx2));
  requireSize(kKtx2, file.size, shTextureSize(box.texel_count));
  if (file.format != Ktx2Format::rgba16f) throw InputError(kKtx2, "vkFormat", "97", "123");
  return shTextureReader(textureOfHalves(file.texels, file.size), box);
}

std::vector<EngineFile> ddsShFiles(const LightVolume& volume) {
  return {{kDds, ddsBytes(shTextureSize(volume.box.texel_count), packShTexture(volume))}};
}

EngineIrradiance readDdsSh(const std::vector<EngineFile>& files, const LightBox& box) {
  const DdsTexture file = parseDds(kDds, fileNamed(files, kDds));
  requireSize(kDds, file.size, shTextureSize(box.texel_count));
  return shTextureReader(textureOfHalves(file.texels, file.size), box);
}

}  // namespace nlg
