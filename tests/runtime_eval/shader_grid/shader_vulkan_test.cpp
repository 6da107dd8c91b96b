#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "nlg/shader_grid.h"
#include "tests/runtime_eval/shader_grid/compute_device.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tests/runtime_eval/shader_grid/places.h"

namespace nlg {
namespace {

constexpr size_t kVulkanPlaces = 1563 * 64;

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
    const ShaderPlaces places = randomPlaces(grid, kVulkanPlaces, 8);
    const std::vector<float> expected = lightAt(grid, places);
    const std::vector<uint32_t> words = places.words();
    const std::vector<uint32_t> lights = device->run(GetParam(), {&packed.words, &words}, expected.size(), kVulkanPlaces / 64);
    float largest = 0.0f;
    for (size_t i = 0; i < kVulkanPlaces; ++i) {
      const float* light = &expected[4 * i];
      ASSERT_EQ(std::bit_cast<float>(lights[4 * i + 3]), light[3]) << i;
      for (size_t c = 0; c < 3; ++c) {
        const float off = std::abs(std::bit_cast<float>(lights[4 * i + c]) - light[c]) / std::max(1.0f, light[c]);
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
