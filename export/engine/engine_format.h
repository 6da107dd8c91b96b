// Formats of `nlg-export engine`, each with a model of how engines read it: the error that the tool prints, and the tests, use
// the very texels and bytes of the files.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "export/engine/light_volume.h"
#include "nlg/look_up.h"
#include "nlg/shader_grid.h"

namespace nlg {

struct EngineFile {
  std::string name, bytes;
};

// Irradiance that an engine shows at a position (finite), on a plane that faces a normal of length 1.
using EngineIrradiance = std::function<std::array<float, kShChannels>(const PositionM& position_m, const float* normal_3)>;

// Resampled: a texture of light_volume.h.
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

// The grid itself, grid.bin as `nlg-export shader` writes it, and what looks up in it.
struct GridFormat {
  const char* name;
  std::vector<EngineFile> (*look_up)(const ShaderGrid& grid);
};

// three-per-pixel: look_up.glsl, and the modules that light three.js's materials by it. c-header: nlg_light_grid.h, for programs in C,
// which needs no library at all.
const std::vector<GridFormat>& gridFormats();

// Files that are part of the tool: runtime_eval/shader_grid/nlg_light_grid.h; the modules of WebGLRenderer and of WebGPURenderer.
extern const std::string_view kCHeaderText, kThreeLightGridText, kThreeLightGridWebgpuText;

// grid.bin, then the format's own files.
std::vector<EngineFile> gridFiles(const GridFormat& format, const ShaderGrid& grid);

// The look-up of nlg_light_grid.h in the bytes of grid.bin.
EngineIrradiance gridIrradiance(std::string bytes);

// What a resampled texture gets wrong of a light grid's own look-up.
//
// Differences from lookUpIrradiance, over the root mean square of irradiance at the same places; red, green and blue count alike.
struct ResamplingError {
  int64_t places = 0;
  double rmse = 0.0, p95 = 0.0;            // of planes that face any direction; p95: of places' own root mean squares
  double axes_rmse = 0.0, axes_p95 = 0.0;  // of planes that face along an axis, as most floors and walls do
};

// At places drawn uniformly in the volume of the used cells, where the look-up is lit, on a plane that faces any direction and on one
// that faces along an axis. The seed is fixed.
//
// box       places outside of it are not drawn; nullptr: all cells
// wanted    places; fewer where so few of those that are drawn are lit, 50 times as many at most
// returns   nothing where no place was lit, or light is 0 at all of them
std::optional<ResamplingError> resamplingError(const LightGrid& grid, const LightBox* box, const EngineIrradiance& irradiance,
                                               int64_t wanted);

// The command nlg-export engine --grid GRID --format FORMAT --out FOLDER
int engineMain(int argc, char** argv);

}  // namespace nlg
