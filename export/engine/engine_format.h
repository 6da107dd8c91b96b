// Formats of `nlg-export engine`, each with a model of how engines read it: the error that the tool prints, and the tests, use
// the very texels and bytes of the files.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "export/engine/light_volume.h"
#include "nlg/look_up.h"

namespace nlg {

struct EngineFile {
  std::string name, bytes;
};

// Irradiance that an engine shows at a position (finite), on a plane that faces a normal of length 1.
using EngineIrradiance = std::function<std::array<float, kShChannels>(const PositionM& position_m, const float* normal_3)>;

// A texture of light_volume.h.
struct TextureFormat {
  const char* name;
  double bias;  // texels that the engine moves positions by, along the normal
  // box      of the texels
  // texels   as packShTexture gives them
  EngineFile (*file)(const LightBox& box, const std::string& texels);
  // The texture read with the engine's own filter and formula.
  EngineIrradiance (*shown)(Texture3d texture, const LightBox& box);
};

// three: light.bin, the texture of a three.js LightProbeGrid (0.187) as it is, without a header. Its shader moves every position by half
// a texel along the normal, and shows nothing where that leaves the box by more than a hundredth of a texel
// (examples/jsm/tsl/lighting/LightProbeGridNode.js; ShaderChunk/lightprobes_pars_fragment.glsl.js).
// ktx2-sh: light.ktx2, the same texture for everybody else, read where a pixel stands.
const std::vector<TextureFormat>& textureFormats();

// null: none has that name
const TextureFormat* findTexture(const std::string& name);
// "three, ktx2-sh, "
std::string textureNames();

}  // namespace nlg
