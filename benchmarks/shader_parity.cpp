// look_up.glsl on Vulkan against lookUpIrradiance, over baked levels: docs/reference/engines.md has its table.
//
//     bench_shader_parity GRID.safetensors...
//
// 100,032 places a grid, each within 1.2 spacings of a probe that is drawn evenly, along each axis; positions are floats for both.
// A number is a channel of irradiance at a place. It differs where |shader - library| is above 1e-3 of the larger of the library's
// number and the mean of all its numbers of that grid. A shader knows a place by its distance from the tree's corner in units,
// rounded to float; "same place" compares with lookUpIrradiance at just that place, so that only the look-up itself is left.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "nlg/shader_grid.h"
#include "tests/runtime_eval/shader_grid/compute_device.h"
#include "tests/runtime_eval/shader_grid/places.h"

namespace nlg {
namespace {

constexpr size_t kPlaces = 1563 * 64;
constexpr double kReach = 1.2;  // spacings
constexpr float kDiffers = 1e-3f;

ShaderPlaces placesNearProbes(const LightGrid& grid) {
  Random random(8);
  ShaderPlaces places;
  for (size_t i = 0; i < kPlaces; ++i) {
    const size_t probe = random.below(static_cast<uint32_t>(grid.tree.probeCount()));
    PositionM at = grid.tree.probePosition(probe);
    for (double& value : at) value += grid.tree.probeSpacing(probe) * random.uniform(-kReach, kReach);
    places.positions_m.push_back(asFloats(at));
    places.normals.push_back(randomNormal(random));
  }
  return places;
}

// Where the shader's float arithmetic takes a position to be.
PositionM asShaded(const ProbeTreeFrame& frame, const PositionM& position_m) {
  PositionM shaded;
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto first_m = static_cast<float>(frame.first_m[axis]), per_m = static_cast<float>(1.0 / frame.spacing_m);
    const float units = (static_cast<float>(position_m[axis]) - first_m) * per_m;
    shaded[axis] = frame.first_m[axis] + double{units} * frame.spacing_m;
  }
  return shaded;
}

struct Difference {
  int other_status = 0, differing = 0;
  float largest = 0.0f;
};

Difference differenceOf(const std::vector<float>& library, const std::vector<uint32_t>& shader) {
  double sum = 0.0;
  for (size_t i = 0; i < library.size(); ++i) sum += i % 4 < 3 ? library[i] : 0.0f;
  const auto mean = static_cast<float>(sum / (3.0 * kPlaces));
  Difference difference;
  for (size_t i = 0; i < library.size(); i += 4) {
    if (std::bit_cast<float>(shader[i + 3]) != library[i + 3]) {
      ++difference.other_status;
      continue;
    }
    for (size_t c = i; c < i + 3; ++c) {
      const float off = std::abs(std::bit_cast<float>(shader[c]) - library[c]) / std::max(mean, library[c]);
      // NaN is no agreement
      if (!(off <= kDiffers)) ++difference.differing;
      difference.largest = std::max(difference.largest, off);
    }
  }
  return difference;
}

void compare(const ComputeDevice& device, const std::string& path) {
  LightGrid grid;
  GridMetadata metadata;
  ShaderGrid packed;
  FileResult result = readLightGridFile(path, &grid, &metadata);
  if (result.ok()) result = packShaderGrid(grid, &packed);
  if (!result.ok()) throw std::runtime_error(path + ": " + fileStatusName(result.status) + ": " + result.detail);
  ShaderPlaces places = placesNearProbes(grid);
  const std::vector<uint32_t> words = places.words();
  const std::vector<uint32_t> shader =
      device.run(NLG_SPIRV_FOLDER "every_grid.spv", {&packed.words, &words}, 4 * kPlaces, kPlaces / 64);
  const Difference given = differenceOf(lightAt(grid, places), shader);
  for (PositionM& position_m : places.positions_m) position_m = asShaded(grid.tree.frame(), position_m);
  const Difference same = differenceOf(lightAt(grid, places), shader);
  std::printf("| %s | %zu | %zu | %d | %d | %.1e | %d | %d | %.1e |\n",
              metadata.contains("scene") ? metadata.at("scene").c_str() : path.c_str(), grid.tree.probeCount(),
              packed.words.size() * sizeof(uint32_t), given.other_status, given.differing, given.largest, same.other_status,
              same.differing, same.largest);
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) try {
  if (argc < 2) throw std::runtime_error("expected light grids (.safetensors)");
  const std::optional<nlg::ComputeDevice> device = nlg::ComputeDevice::find();
  if (!device) throw std::runtime_error("no Vulkan device, not even a software one (Debian: mesa-vulkan-drivers)");
  std::printf("On %s, %zu places a grid.\n\n", device->name().c_str(), nlg::kPlaces);
  std::printf(
      "| scene | probes | bytes | other status | numbers that differ | largest | same place: other status | differ | largest "
      "|\n");
  std::printf("|---|---|---|---|---|---|---|---|---|\n");
  for (int i = 1; i < argc; ++i) nlg::compare(*device, argv[i]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_shader_parity: %s\n", error.what());
  return 1;
}
