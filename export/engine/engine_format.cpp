#include "export/engine/engine_format.h"

#include <algorithm>

#include "export/engine/ambient_cubes.h"
#include "export/engine/bevy_format.h"
#include "export/engine/godot_format.h"
#include "export/engine/sh_files_format.h"
#include "export/engine/sh_texture.h"
#include "export/engine/three_format.h"
#include "tool/error.h"

namespace nlg {

const std::string& fileNamed(const std::vector<EngineFile>& files, const std::string& name) {
  const auto found = std::find_if(files.begin(), files.end(), [&](const EngineFile& file) { return file.name == name; });
  if (found == files.end()) throw InputError(name, "the format's files", "all of them", "none of this name");
  return found->bytes;
}

EngineIrradiance shTextureReader(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    return shTextureIrradiance(texture, box, position_m, normal_3);
  };
}

void requireSize(const std::string& name, const TextureSize& size, const TextureSize& expected) {
  const auto text = [](const TextureSize& of) {
    return std::to_string(of[0]) + " x " + std::to_string(of[1]) + " x " + std::to_string(of[2]) + " texels";
  };
  if (size != expected) throw InputError(name, "size", text(expected), text(size));
}

const std::vector<EngineFormat>& engineFormats() {
  static const std::vector<EngineFormat> formats = {{"three", shTextureSize, threeFiles, readThree},
                                                    {"bevy", ambientCubesSize, bevyFiles, readBevy},
                                                    {"godot", shTextureSize, godotFiles, readGodot},
                                                    {"ktx2-sh", shTextureSize, ktx2ShFiles, readKtx2Sh},
                                                    {"dds-sh", shTextureSize, ddsShFiles, readDdsSh}};
  return formats;
}

const EngineFormat* findEngineFormat(std::string_view name) {
  for (const EngineFormat& format : engineFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

}  // namespace nlg
