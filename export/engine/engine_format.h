// The formats that `nlg-export engine` writes light in, each with what an engine makes of it: tests and the error that the tool states
// read what was written.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "export/engine/light_volume.h"
#include "export/engine/texture_3d.h"

namespace nlg {

struct EngineFile {
  std::string name, bytes;
};

// throws   InputError naming the file where it is not among them
const std::string& fileNamed(const std::vector<EngineFile>& files, const std::string& name);

// Irradiance that an engine shows at a position (finite), on a plane that faces a normal of length 1.
using EngineIrradiance = std::function<std::array<float, kShChannels>(const PositionM& position_m, const float* normal_3)>;

// Of a texture of sh_texture.h that is read where a pixel stands.
EngineIrradiance shTextureReader(Texture3d texture, const LightBox& box);

// throws   InputError naming the file where the sizes differ
void requireSize(const std::string& name, const TextureSize& size, const TextureSize& expected);

struct EngineFormat {
  const char* name;
  // of the texture that holds a box of so many texels
  TextureSize (*texture_size)(const TextureSize& box_texels);
  // volume    |coefficients| <= kMaxEngineLight
  std::vector<EngineFile> (*write)(const LightVolume& volume);
  // Decodes the files, and reads them with the engine's filter and formula.
  // box      where the texture stands, as light.json says
  // throws   InputError naming a file that write does not give
  EngineIrradiance (*read)(const std::vector<EngineFile>& files, const LightBox& box);
};

// three, bevy, godot, ktx2-sh, dds-sh
const std::vector<EngineFormat>& engineFormats();

// nullptr where there is none of that name
const EngineFormat* findEngineFormat(std::string_view name);

}  // namespace nlg
