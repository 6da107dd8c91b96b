// For three_test.py:
//
//     three_cases grid OUT.safetensors                       a grid with functions of every representation
//     three_cases places GRID FOLDER OFFSET_M COUNT          places in a grid's level, as JSON: for each of them
//
//         position, normal    three floats each
//         per_pixel           irradiance by lookUpIrradiance, OFFSET_M before the place
//         texture             irradiance that three.js shows of the light.json and light.bin in FOLDER, where it has them
//         bound               of what a GPU's linear filter may be off by there
//
// A filter's weights have eight bits behind the point, as Direct3D demands: a GPU reads up to 2^-8 of a texel away, along each axis.
// What that takes or adds along one axis is found by reading there, and the three axes add up. The filter may be one of halves: three
// rounded terms, of the orders 0, 1 and 2, each off by 2^-11 of the largest light at most.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include <nlohmann/json.hpp>

#include "export/engine/engine_format.h"
#include "export/engine/light_volume.h"
#include "runtime_eval/light_grid/grid_summary.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

constexpr double kFilterStep = 0x1p-8;  // texels
constexpr size_t kOutsideEvery = 16;

void require(const FileResult& result, const std::string& path) {
  if (!result.ok()) throw std::runtime_error(path + ": " + result.detail);
}

void writeGrid(const std::string& path) {
  std::string bytes;
  require(serializeLightGrid(everyRepresentation(ThetaPrecision::int8, 7), {}, {{"scene", "every representation"}}, &bytes),
          path);
  writeFileAtomically(path, bytes);
}

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

PositionM before(const PositionM& position_m, const std::array<float, 3>& normal, double offset_m) {
  PositionM moved_m;
  for (size_t axis = 0; axis < 3; ++axis) moved_m[axis] = position_m[axis] + offset_m * normal[axis];
  return moved_m;
}

// Float takes it to no other unit.
bool isClear(const ProbeTreeFrame& frame, const PositionM& position_m) {
  for (size_t axis = 0; axis < 3; ++axis) {
    const double units = (position_m[axis] - frame.first_m[axis]) / frame.spacing_m;
    if (std::abs(units - std::round(units)) < 1e-3) return false;
  }
  return true;
}

class LevelPlaces {
 public:
  LevelPlaces(const LightGrid& grid, const LightBox& box, double offset_m) : grid_(grid), box_(box), offset_m_(offset_m) {}

  // Inside the box by a texel, or two texels outside of it along one axis; and a normal.
  std::pair<PositionM, std::array<float, 3>> draw(bool is_outside) {
    for (;;) {
      PositionM position_m;
      for (size_t axis = 0; axis < 3; ++axis) {
        const double texel_m = texelM(axis);
        position_m[axis] = random_.uniform(box_.low_m[axis] + texel_m, box_.high_m[axis] - texel_m);
      }
      if (is_outside) {
        const uint32_t axis = random_.below(3);
        position_m[axis] = box_.high_m[axis] + 2.0 * texelM(axis);
      }
      position_m = asFloats(position_m);
      const std::array<float, 3> normal = randomNormal(random_);
      if (isClear(grid_.tree.frame(), before(position_m, normal, offset_m_))) return {position_m, normal};
    }
  }

  double texelM(size_t axis) const { return (box_.high_m[axis] - box_.low_m[axis]) / box_.texel_count[axis]; }

 private:
  const LightGrid& grid_;
  LightBox box_;
  double offset_m_;
  Random random_{mixSeed(1, 0x7468726565)};
};

// What a filter's steps come to at a place: the largest over the channels.
float filterBound(const EngineIrradiance& irradiance, const LevelPlaces& places, const PositionM& position_m,
                  const float* normal_3) {
  const std::array<float, 3> here = irradiance(position_m, normal_3);
  std::array<float, 3> sum{};
  for (size_t axis = 0; axis < 3; ++axis) {
    PositionM low_m = position_m, high_m = position_m;
    low_m[axis] -= kFilterStep * places.texelM(axis), high_m[axis] += kFilterStep * places.texelM(axis);
    const std::array<float, 3> low = irradiance(low_m, normal_3), high = irradiance(high_m, normal_3);
    for (size_t c = 0; c < 3; ++c) sum[c] += std::max(std::abs(low[c] - here[c]), std::abs(high[c] - here[c]));
  }
  return *std::max_element(sum.begin(), sum.end());
}

void writePlaces(const std::string& grid_path, const std::filesystem::path& folder, double offset_m, size_t count) {
  LightGrid grid;
  GridMetadata metadata;
  require(readLightGridFile(grid_path, &grid, &metadata), grid_path);
  const GridBounds bounds = boundsOf(grid.tree);
  LightBox box = texelBox(bounds.low_m, bounds.high_m, grid.tree.frame().spacing_m);
  EngineIrradiance irradiance = [](const PositionM&, const float*) { return std::array<float, 3>{}; };
  if (std::filesystem::exists(folder / "light.json")) {
    const nlohmann::json place = nlohmann::json::parse(bytesOf(folder / "light.json"));
    box = {place.at("low_m").get<PositionM>(), place.at("high_m").get<PositionM>(), place.at("resolution").get<TextureSize>()};
    irradiance =
        textureFormats().front().shown(textureOfHalves(bytesOf(folder / "light.bin"), shTextureSize(box.texel_count)), box);
  }
  LevelPlaces places(grid, box, offset_m);
  nlohmann::json json = nlohmann::json::array();
  float largest = 0.0f;
  for (size_t i = 0; i < count; ++i) {
    const auto [position_m, normal] = places.draw(i % kOutsideEvery == kOutsideEvery - 1);
    std::array<float, 3> per_pixel;
    lookUpIrradiance(grid, before(position_m, normal, offset_m), normal.data(), per_pixel.data());
    const std::array<float, 3> shown = irradiance(position_m, normal.data());
    for (const float channel : shown) largest = std::max(largest, channel);
    json.push_back({{"position", position_m},
                    {"normal", normal},
                    {"per_pixel", per_pixel},
                    {"texture", shown},
                    {"bound", filterBound(irradiance, places, position_m, normal.data())}});
  }
  for (nlohmann::json& of : json) of["bound"] = of["bound"].get<float>() + 3 * 0x1p-11f * largest;
  std::cout << json.dump() << '\n';
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) try {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "grid") {
    nlg::writeGrid(arguments[1]);
  } else if (arguments.size() == 5 && arguments[0] == "places") {
    nlg::writePlaces(arguments[1], arguments[2], std::stod(arguments[3]), std::stoul(arguments[4]));
  } else {
    throw std::runtime_error("expected grid or places, and what belongs to them");
  }
} catch (const std::exception& error) {
  std::cerr << "three_cases: " << error.what() << '\n';
  return 1;
}
