#include "export/shader/shader_export.h"

#include <CLI/CLI.hpp>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <iterator>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"

namespace nlg {
namespace {

constexpr size_t kWord = sizeof(uint32_t), kCorners = 8;

namespace fs = std::filesystem;

constexpr const char* kFiles[] = {"grid.bin", "look_up.glsl", "resample.comp", "resampled.glsl"};

// By the head of grid.bin: axes of light, bits of a record's scale, groups (docs/reference/formats.md).
bool isGrid(std::string_view bytes) {
  const auto word = [&](size_t i) {
    uint32_t value;
    std::memcpy(&value, &bytes[kWord * i], kWord);
    return value;
  };
  return bytes.size() >= 32 * kWord && bytes.size() % (4 * kWord) == 0 && word(16) <= 27 && word(17) <= 31 && word(19) <= 16;
}

void run(const std::string& grid_path, const std::string& folder, const std::vector<double>& origin_m) {
  // refusals before the grid is read
  requireOutputFolder(folder);
  for (const char* name : kFiles) refuseToReplace((fs::path(folder) / name).string(), {grid_path}, kExportedFiles);
  LightGrid grid;
  GridMetadata metadata;
  requireRead(grid_path, readLightGridFile(grid_path, &grid, &metadata), "a light grid");
  moveToOrigin(origin_m, &grid);
  ShaderGrid packed;
  const FileResult result = packShaderGrid(grid, &packed);
  if (!result.ok()) throw InputError(grid_path, fileStatusName(result.status), "a grid that shaders can show", result.detail);
  writeShader(packed, folder);
  // bytes that a pixel reads of the buffer
  const PixelReads reads = pixelReads(packed);
  const nlohmann::ordered_json line = {
      {"scene", metadata.contains("scene") ? metadata["scene"] : ""},
      {"probes", grid.tree.probeCount()},
      {"origin_m", origin_m},
      {"corner_error_m", cornerErrorM(grid.tree.frame())},
      {"bytes", packed.words.size() * kWord},
      {"tree_bytes", packed.tree_bytes},
      {"light_bytes", packed.light_bytes},
      {"theta_bytes", packed.theta_bytes},
      {"defines", packed.defines},
      {"light_groups", packed.groups},
      {"first_colour", packed.first_colour},
      {"pixel_reads", {{"cell", reads.cell}, {"bare_tents", reads.tents}, {"functions", reads.functions}}}};
  std::cout << line.dump() << '\n';
}

}  // namespace

const OwnFiles kExportedFiles = {
    "a file of nlg-export", [](std::string_view bytes) { return hold(bytes, "nlg") || hold(bytes, "Nlg") || isGrid(bytes); }};

std::string shaderText(const ShaderGrid& grid) {
  std::string text = "// Made by nlg-export shader for one grid: grid.bin, beside this file.\n";
  for (const std::string& define : grid.defines) text += "#define " + define + "\n";
  text += "#define NLG_NEAR\n";
  for (size_t g = 0; g < grid.groups.size(); ++g)
    text += "// light group " + std::to_string(g) + ", its colour in uvec4 " +
            std::to_string(static_cast<size_t>(grid.first_colour) + g) + " of the head: " + grid.groups[g] + "\n";
  text += "\n";
  return text.append(kLookUpText);
}

std::string shaderGridBytes(const ShaderGrid& grid) {
  std::string bytes;
  bytes.reserve(grid.words.size() * kWord);
  for (const uint32_t word : grid.words) {
    for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(word >> shift & 0xff));
  }
  return bytes;
}

void writeShader(const ShaderGrid& grid, const std::string& folder) {
  const std::string texts[] = {shaderGridBytes(grid), shaderText(grid), std::string(kResampleText), std::string(kResampledText)};
  for (size_t i = 0; i < std::size(kFiles); ++i) writeFileAtomically((fs::path(folder) / kFiles[i]).string(), texts[i]);
}

void addOriginOption(CLI::App& app, std::vector<double>* origin_m) {
  app.add_option("--origin-m", *origin_m,
                 "origin of the engine's coordinates in the level: x,y,z, metres. For levels far from their origin, because "
                 "engine files hold floats")
      ->delimiter(',')
      ->expected(3);
}

void moveToOrigin(const std::vector<double>& origin_m, LightGrid* grid) {
  grid->tree.moveBy({-origin_m[0], -origin_m[1], -origin_m[2]});
}

PixelReads pixelReads(const ShaderGrid& grid) {
  PixelReads reads;
  // the low corner's slot says whether the cell is used, and is read again as a corner
  reads.cell = kWord * (1 + 1 + kCorners);
  reads.tents = reads.cell + kCorners * grid.light_read;
  reads.functions = reads.cell + kCorners * grid.largest_read;
  return reads;
}

int shaderMain(int argc, char** argv) {
  CLI::App app{"Writes a light grid for shaders, with the shader code of its look-up.", "nlg-export shader"};
  std::string grid, out;
  std::vector<double> origin_m(3, 0.0);
  OptionTable table("export");
  app.add_option("--grid", grid, "light grid that holds light (.safetensors)")->required();
  app.add_option("--out", out, "folder for grid.bin, look_up.glsl, resample.comp and resampled.glsl")->required();
  addOriginOption(app, &origin_m);
  return runTool(argc, argv, app, table, [&] { run(grid, out, origin_m); });
}

}  // namespace nlg
