#include "export/shader/shader_export.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <iterator>

#include <nlohmann/json.hpp>

#include "runtime_eval/light_grid/grid_summary.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"

namespace nlg {
namespace {

constexpr size_t kWord = sizeof(uint32_t), kCorners = 8;

namespace fs = std::filesystem;

using Texts = std::vector<std::pair<std::string, std::string>>;  // file names and what they hold

struct ShaderFormat {
  const char* name;
  Texts (*texts)(const ShaderGrid& grid);
};

const ShaderFormat kFormats[] = {
    {"glsl",
     [](const ShaderGrid& grid) {
       return Texts{{"look_up.glsl", shaderText(grid)},
                    {"resample.comp", std::string(kResampleText)},
                    {"resampled.glsl", std::string(kResampledText)}};
     }},
    {"three-per-pixel",
     [](const ShaderGrid& grid) {
       return Texts{{"look_up.glsl", shaderText(grid)},
                    {"three_light_grid.js", std::string(kThreeText)},
                    {"three_light_grid_webgpu.js", std::string(kThreeWebgpuText)}};
     }},
    {"c-header",
     [](const ShaderGrid& /*grid*/) {
       return Texts{{"nlg_light_grid.h", std::string(kCHeaderText)}};
     }},
};

std::string formatNames() {
  std::string names;
  for (const ShaderFormat& format : kFormats) names += (names.empty() ? "" : ", ") + std::string(format.name);
  return names;
}

// grid.bin, then the format's own files.
Texts filesOf(const ShaderGrid& grid, const std::string& name) {
  for (const ShaderFormat& format : kFormats) {
    if (format.name != name) continue;
    Texts files = format.texts(grid);
    files.insert(files.begin(), {"grid.bin", shaderGridBytes(grid)});
    return files;
  }
  throw UsageError("--format", formatNames(), "'" + name + "'");
}

// By the head of grid.bin: axes of light, bits of a record's scale, groups (docs/reference/formats.md).
bool isGrid(std::string_view bytes) {
  const auto word = [&](size_t i) {
    uint32_t value;
    std::memcpy(&value, &bytes[kWord * i], kWord);
    return value;
  };
  return bytes.size() >= 32 * kWord && bytes.size() % (4 * kWord) == 0 && word(16) <= 27 && word(17) <= 31 && word(19) <= 16;
}

void run(const std::string& grid_path, const std::string& folder, const std::string& format,
         const std::vector<double>& origin_m) {
  // refusals before the grid is read
  for (const double number : origin_m) {
    if (!std::isfinite(number)) throw UsageError("--origin-m", "three finite numbers", fmt::format("{}", number));
  }
  const Texts files = filesOf({}, format);
  requireOutputFolder(folder);
  for (const auto& file : files) refuseToReplace((fs::path(folder) / file.first).string(), {grid_path}, kExportedFiles);
  LightGrid grid;
  GridMetadata metadata;
  requireRead(grid_path, readLightGridFile(grid_path, &grid, &metadata), "a light grid");
  grid.tree.moveBy({-origin_m[0], -origin_m[1], -origin_m[2]});
  ShaderGrid packed;
  const FileResult result = packShaderGrid(grid, &packed);
  if (!result.ok()) throw InputError(grid_path, fileStatusName(result.status), "a grid that shaders can show", result.detail);
  writeShader(packed, folder, format);
  // bytes that a pixel reads of the buffer
  const PixelReads reads = pixelReads(packed);
  const GridBounds bounds = boundsOf(grid.tree);
  const nlohmann::ordered_json line = {
      {"scene", metadata.contains("scene") ? metadata["scene"] : ""},
      {"probes", grid.tree.probeCount()},
      {"origin_m", origin_m},
      {"corner_error_m", cornerErrorM(grid.tree.frame())},
      {"low_m", bounds.low_m},
      {"high_m", bounds.high_m},
      {"mean_radiance", meanRadiance(grid)},
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

// By the name at its beginning: somewhere in many megabytes of numbers these letters stand by chance.
const OwnFiles kExportedFiles = {"a file of nlg-export", [](std::string_view bytes) {
                                   const std::string_view head = bytes.substr(0, 1 << 14);
                                   return hold(head, "nlg") || hold(head, "Nlg") || isGrid(bytes);
                                 }};

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

void writeShader(const ShaderGrid& grid, const std::string& folder, const std::string& format) {
  for (const auto& [name, text] : filesOf(grid, format)) writeFileAtomically((fs::path(folder) / name).string(), text);
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
  CLI::App app{"Writes a light grid with its look-up, for those who can change their shaders.", "nlg-export shader"};
  std::string grid, out, format = "glsl";
  std::vector<double> origin_m(3, 0.0);
  OptionTable table("export");
  app.add_option("--grid", grid, "light grid that holds light (.safetensors)")->required();
  app.add_option("--out", out, "folder for grid.bin and the format's files")->required();
  app.add_option("--format", format, formatNames())->capture_default_str();
  app.add_option("--origin-m", origin_m,
                 "origin of the engine's coordinates in the level: x,y,z, metres. For levels far from their origin, because "
                 "engine files hold floats")
      ->delimiter(',')
      ->expected(3);
  return runTool(argc, argv, app, table, [&] { run(grid, out, format, origin_m); });
}

}  // namespace nlg
