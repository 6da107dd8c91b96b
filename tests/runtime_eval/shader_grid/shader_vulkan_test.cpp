#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "runtime_eval/light_grid/irradiance.h"
#include "runtime_eval/shader_grid/shader_grid.h"
#include "tests/runtime_eval/shader_grid/compute_device.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"

namespace nlg {
namespace {

constexpr int kPlaces = 1563 * 64;

class ShaderOnVulkan : public testing::TestWithParam<const char*> {};

TEST_P(ShaderOnVulkan, SaysWhatTheLookUpSays) {
  const std::optional<ComputeDevice> device = ComputeDevice::find();
  if (!device) GTEST_SKIP() << "no Vulkan device, not even a software one (Debian: mesa-vulkan-drivers)";
  EXPECT_TRUE(device->isValidated()) << "no validation layer (Debian: vulkan-validationlayers)";
  std::cout << "on " << device->name() << '\n';
  for (const ThetaPrecision precision : {ThetaPrecision::int8, ThetaPrecision::float16}) {
    const LightGrid grid = everyRepresentation(precision, 7);
    ShaderGrid packed;
    ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
    Random random(8);
    std::vector<PositionM> positions;
    std::vector<std::array<float, 3>> normals;
    std::vector<uint32_t> places;
    for (int i = 0; i < kPlaces; ++i) {
      positions.push_back(randomPlace(grid.tree.frame(), random));
      normals.push_back(randomNormal(random));
      for (const double value : positions.back()) places.push_back(std::bit_cast<uint32_t>(static_cast<float>(value)));
      places.push_back(0);
      for (const float value : normals.back()) places.push_back(std::bit_cast<uint32_t>(value));
      places.push_back(0);
    }
    const std::vector<uint32_t> lights = device->run(GetParam(), {&packed.words, &places}, size_t{4} * kPlaces, kPlaces / 64);
    float largest = 0.0f;
    for (int i = 0; i < kPlaces; ++i) {
      float rgb[3];
      const LightStatus status = lookUpIrradiance(grid, positions[i], normals[i].data(), rgb);
      ASSERT_EQ(std::bit_cast<float>(lights[4 * i + 3]), static_cast<float>(status)) << i;
      for (int c = 0; c < 3; ++c) {
        const float shaded = std::bit_cast<float>(lights[4 * i + c]), off = std::abs(shaded - rgb[c]) / std::max(1.0f, rgb[c]);
        ASSERT_LE(off, 1e-3f) << i;
        largest = std::max(largest, off);
      }
    }
    std::cout << thetaPrecisionName(precision) << ": largest difference " << largest << '\n';
  }
  for (const std::string& message : device->messages()) ADD_FAILURE() << message;
}

INSTANTIATE_TEST_SUITE_P(Languages, ShaderOnVulkan, testing::Values(NLG_LOOK_UP_SPIRV, NLG_LOOK_UP_HLSL_SPIRV),
                         [](const auto& module) { return module.index == 0 ? "glsl" : "hlsl"; });

}  // namespace
}  // namespace nlg
