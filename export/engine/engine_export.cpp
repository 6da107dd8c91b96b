
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "export/engine/engine_folder.h"
#include "export/engine/light_volume.h"
#include "export/shader/shader_export.h"
#include "runtime_eval/light_grid/grid_summary.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

const GridFormat* findGridFormat(const std::string& name) {
  for (const GridFormat& format : gridFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

struct EngineRequest {
  std::string grid, format, out;
  std::vector<double> origin_m = {0.0, 0.0, 0.0};
};

struct EngineOptions {
  VolumeOptions volume;
  double intensity = 1.0;  // of the grid's light in the files
  std::vector<std::string> light_groups;
  int error_samples = 20000;
};

std::string formatNames() { return textureNames() + gridFormats()[0].name + ", or " + gridFormats()[1].name; }

constexpr float kMostFactor = 1e6f;

// By group. asked   NAME or NAME=FACTOR, of a group or of all groups of a light state; none: as the grid begins
std::vector<float> groupFactors(const LightGrid& grid, const std::vector<std::string>& asked) {
  std::vector<float> factors;
  // without a wish the grid's own start; with one, only what it names
  for (const std::array<float, 3>& colour : startingColours(grid)) factors.push_back(asked.empty() ? colour[0] : 0.0f);
  std::vector<bool> is_taken(factors.size(), false);
  for (const std::string& text : asked) {
    const size_t equals = text.rfind('=');
    const std::string name = text.substr(0, equals);
    float factor = 1.0f;
    bool is_number = true, is_known = false;
    if (equals != std::string::npos) {
      const auto [end, error] = std::from_chars(&text[equals + 1], text.data() + text.size(), factor);
      is_number = error == std::errc() && end == text.data() + text.size() && std::isfinite(factor) && factor >= 0.0f &&
                  factor <= kMostFactor;
    }
    std::string names;
    for (size_t g = 0; g < grid.groups.size(); ++g) {
      const std::string& group = grid.groups[g].name;
      names += (g == 0 ? "" : ", ") + group;
      // a name stands for a group, or for a light state, whose groups begin with it
      if (group != name && !group.starts_with(name + "/")) continue;
      if (is_taken[g]) throw UsageError("light_groups", "each group once", group + " twice");
      factors[g] = factor;
      is_known = is_taken[g] = true;
    }
    if (!is_known || !is_number) {
      throw UsageError(
          "light_groups",
          "NAME, or NAME=FACTOR from 0 to a million, of the grid's groups of light: " + (names.empty() ? "none" : names),
          "'" + text + "'");
    }
  }
  return factors;
}

LightGrid readGrid(const std::string& path, double intensity, GridMetadata* metadata) {
  LightGrid grid;
  requireRead(path, readLightGridFile(path, &grid, metadata), "a light grid");
  if (grid.light.empty()) throw InputError(path, "light", "a grid that was baked with light", "a grid without light");
  // packed light is multiplied by its unit, so that it is not packed, and rounded, once more
  if (intensity != 1.0) {
    grid.packed_light.unit *= static_cast<float>(intensity);
    if (const FileResult result = takePackedLight(&grid); !result.ok())
      throw UsageError("intensity: light overflows: " + result.detail);
  }
  if (grid.tree.cellCount() == 0) throw InputError(path, "tree", "a used cell", "none");
  return grid;
}

LightVolume readVolume(const LightGrid& grid, const EngineRequest& request, const EngineOptions& options) {
  const LightBox box = volumeBox(grid, options.volume);
  requireTexture(box);
  LightVolume volume = makeLightVolume(grid, box);
  if (volume.lit == 0) throw UsageError("extent_m", "a box in which the grid has light", "none");
  if (const float largest = largestLight(volume); largest > kMaxEngineLight) {
    const double fits = options.intensity * intensityThatFits(largest);
    throw InputError(request.grid, "light", "coefficients of at most " + std::to_string(static_cast<int>(kMaxEngineLight)),
                     fmt::format("{:g}: --intensity {:g} makes them fit", largest, fits));
  }
  return volume;
}

size_t bytesOf(const std::vector<EngineFile>& files) {
  size_t bytes = 0;
  for (const EngineFile& file : files) bytes += file.bytes.size();
  return bytes;
}

nlohmann::ordered_json errorJson(const std::optional<ResamplingError>& error) {
  if (!error) return nullptr;
  return {{"places", error->places},
          {"rmse", error->rmse},
          {"p95", error->p95},
          {"axes_rmse", error->axes_rmse},
          {"axes_p95", error->axes_p95}};
}

void writeGrid(const LightGrid& grid, const GridFormat& format, const EngineRequest& request, const EngineOptions& options,
               nlohmann::ordered_json line) {
  ShaderGrid packed;
  const FileResult result = packShaderGrid(grid, &packed);
  if (!result.ok()) throw InputError(request.grid, fileStatusName(result.status), "a grid that shaders can show", result.detail);
  const std::vector<EngineFile> files = gridFiles(format, packed);
  line["bytes"] = bytesOf(files);
  line["corner_error_m"] = cornerErrorM(grid.tree.frame());
  line["error"] = errorJson(resamplingError(grid, nullptr, gridIrradiance(files.front().bytes), options.error_samples));
  writeEngineFolder(request.out, {"light.json", {}}, files, {request.grid});
  std::cout << line.dump() << '\n';
}

void run(const EngineRequest& request, const EngineOptions& options, const OptionTable& table) {
  const TextureFormat* format = findTexture(request.format);
  const GridFormat* grid_format = findGridFormat(request.format);
  if (format == nullptr && grid_format == nullptr) throw UsageError("--format", formatNames(), "'" + request.format + "'");
  if (grid_format != nullptr &&
      (!options.volume.extent_m.empty() || options.volume.spacing_m > 0.0 || !options.light_groups.empty()))
    throw UsageError("--format " + request.format +
                     " cannot be combined with extent_m, spacing_m and light_groups: it has no texels");
  if (request.out.empty()) throw UsageError("--out", "the name of a folder", "an empty text");
  GridMetadata metadata;
  LightGrid grid = readGrid(request.grid, options.intensity, &metadata);
  moveToOrigin(request.origin_m, &grid);
  nlohmann::ordered_json line = {{"scene", metadata.contains("scene") ? metadata["scene"] : ""},
                                 {"format", request.format},
                                 {"intensity", options.intensity},
                                 {"origin_m", request.origin_m}};
  if (grid_format != nullptr) return writeGrid(grid, *grid_format, request, options, std::move(line));

  // a texture holds one light: groups are mixed before it is resampled
  const std::vector<float> factors = groupFactors(grid, options.light_groups);
  nlohmann::ordered_json groups = nlohmann::ordered_json::object();
  std::vector<std::array<float, 3>> colours;
  for (size_t g = 0; g < factors.size(); ++g) {
    groups[grid.groups[g].name] = factors[g];
    colours.emplace_back().fill(factors[g]);
  }
  if (!colours.empty()) {
    if (const FileResult result = mixLight(colours, &grid); !result.ok())
      throw UsageError("light_groups: light overflows: " + result.detail);
  }
  const LightVolume volume = readVolume(grid, request, options);
  const LightBox& box = volume.box;
  const TextureSize size = shTextureSize(box.texel_count);
  const std::string texels = packShTexture(volume);
  // where the texture lies: for light.json and for the tool's own line
  nlohmann::ordered_json place = placeJson(box);
  line.update(place);
  line["light_groups"] = place["light_groups"] = groups;
  line["texels"] = {{"lit", volume.lit}, {"filled", volume.filled}};
  place["format"] = request.format;
  place["origin_m"] = request.origin_m;
  place["intensity"] = options.intensity;
  place["mean_radiance"] = meanRadiance(grid);
  place["provenance"] = provenance("nlg-export engine", table.toJson(), {{"grid", fileSha256(request.grid)}});
  const EngineFile record = {"light.json", place.dump(2) + "\n"}, file = format->file(box, texels);
  line["bytes"] = bytesOf({file, record});
  // measured on the halves that are written, filtered as the engine does
  line["error"] =
      errorJson(resamplingError(grid, &box, format->shown(textureOfHalves(texels, size), box), options.error_samples));
  writeEngineFolder(request.out, record, {file}, {request.grid});
  std::cout << line.dump() << '\n';
}

}  // namespace

int engineMain(int argc, char** argv) {
  CLI::App app{"Writes a light grid as files that engines load, and measures the error of their textures against the look-up.",
               "nlg-export engine"};
  EngineRequest request;
  EngineOptions options;
  OptionTable table("export");
  table.add("extent_m", &options.volume.extent_m,
            "box of the texture: --extent-m=x,y,z,X,Y,Z, low and high corner, metres. None: the grid's used cells and a texel on "
            "every side");
  table.add("spacing_m", &options.volume.spacing_m, "maximum texel size, metres. 0: half of the grid's finest spacing", 0.0, 1e6);
  table.add("intensity", &options.intensity, "factor on the grid's light. light.json records it", 1e-12, 1e12);
  table.add("light_groups", &options.light_groups,
            "light groups in a texture: NAME or NAME=FACTOR, of a group or a whole light state. None: the grid's default");
  table.add("error_samples", &options.error_samples, "number of sample points at which the error is measured", 1, 100000000);
  table.common({"grid", "format", "out", "origin_m", "extent_m", "spacing_m", "intensity", "light_groups"});
  app.add_option("--grid", request.grid, "light grid that holds light (.safetensors)")->required();
  app.add_option("--format", request.format, formatNames())->required();
  app.add_option("--out", request.out, "folder for the format's files")->required();
  addOriginOption(app, &request.origin_m);
  return runTool(argc, argv, app, table, [&] { run(request, options, table); });
}

}  // namespace nlg
