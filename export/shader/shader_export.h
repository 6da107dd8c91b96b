// The command `nlg-export shader`: writes a light grid for shaders.
//
//     grid.bin       the words of ShaderGrid (include/nlg/shader_grid.h), little-endian: what a buffer or a texture of
//                    four 32-bit integers holds
//     look_up.glsl   the look-up, with the defines of this grid before it
//     resample.comp, resampled.glsl    the compute pass that fills a 3-D texture by it, and what reads that texture
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nlg/shader_grid.h"
#include "tool/output_path.h"

namespace CLI {
class App;
}

namespace nlg {

// What nlg-export may overwrite: texts and files that name their tool, and grid.bin.
extern const OwnFiles kExportedFiles;

extern const std::string_view kLookUpText, kResampleText, kResampledText;  // of runtime_eval/shader_grid/

// look_up.glsl of one grid.
std::string shaderText(const ShaderGrid& grid);

// grid.bin.
std::string shaderGridBytes(const ShaderGrid& grid);

// Writes all of it into a folder, and makes that where it is missing.
void writeShader(const ShaderGrid& grid, const std::string& folder);

// What one pixel reads of grid.bin at most, bytes, the head left out.
struct PixelReads {
  size_t cell = 0;       // a block and a brick's slots
  size_t tents = 0;      // all of it, where all eight probes have bare tents
  size_t functions = 0;  // all of it, where all eight have functions of the largest class
};
PixelReads pixelReads(const ShaderGrid& grid);

// --origin-m of the commands that export grids, and what it does: three numbers, world coordinates of what engines count from.
void addOriginOption(CLI::App& app, std::vector<double>* origin_m);
void moveToOrigin(const std::vector<double>& origin_m, LightGrid* grid);

// The tool's command `shader`: nlg-export shader --grid GRID --out FOLDER.
int shaderMain(int argc, char** argv);

}  // namespace nlg
