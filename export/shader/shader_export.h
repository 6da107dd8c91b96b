// The command `nlg-export shader`: writes a light grid with its own look-up, for those who can change their shaders.
//
//     grid.bin       the words of ShaderGrid (include/nlg/shader_grid.h), little-endian: what a buffer or a texture of
//                    four 32-bit integers holds
//
// and by format
//
//     glsl              look_up.glsl, the look-up with the defines of this grid before it; resample.comp, resampled.glsl, the compute
//                       pass that fills a 3-D texture by it, and what reads that texture
//     three-per-pixel   look_up.glsl, and the modules that light materials of three.js (WebGLRenderer, WebGPURenderer) by it
//     c-header          nlg_light_grid.h, for programs in C, which needs no library at all
#pragma once

#include <string>
#include <string_view>

#include "nlg/shader_grid.h"
#include "tool/output_path.h"

namespace nlg {

// What nlg-export may overwrite: texts and files that name their tool, and grid.bin.
extern const OwnFiles kExportedFiles;

// of runtime_eval/shader_grid/, and of this folder
extern const std::string_view kLookUpText, kResampleText, kResampledText, kCHeaderText, kThreeText, kThreeWebgpuText;

// look_up.glsl of one grid.
std::string shaderText(const ShaderGrid& grid);

// grid.bin.
std::string shaderGridBytes(const ShaderGrid& grid);

// Writes all files of a format into a folder, and makes that where it is missing.
// throws   UsageError naming --format where there is none of that name
void writeShader(const ShaderGrid& grid, const std::string& folder, const std::string& format = "glsl");

// What one pixel reads of grid.bin at most, bytes, the head left out.
struct PixelReads {
  size_t cell = 0;       // a block and a brick's slots
  size_t tents = 0;      // all of it, where all eight probes have bare tents
  size_t functions = 0;  // all of it, where all eight have functions of the largest class
};
PixelReads pixelReads(const ShaderGrid& grid);

// The tool's command `shader`: nlg-export shader --grid GRID --out FOLDER --format FORMAT.
int shaderMain(int argc, char** argv);

}  // namespace nlg
