#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>

#include "nlg/look_up.h"
#include "nlg/shader_grid.h"
#include "tests/runtime_eval/shader_grid/compute_device.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tests/runtime_eval/shader_grid/resampled_box.h"

namespace nlg {
namespace {

uint32_t floatBits(double value) { return std::bit_cast<uint32_t>(static_cast<float>(value)); }

// A texture on a device, filled by resample.comp.
struct Texture {
  LightBox box;
  std::vector<float> expected;  // kTexelNumbers a texel
  float scale = 0.0f;
  ComputeDevice::Image image;

  Texture(const ComputeDevice& device, const LightGrid& grid, const std::string& spirv_path) : box(boxOf(grid.tree.frame())) {
    expected = texelNumbers(grid, box);
    ShaderGrid packed;
    EXPECT_TRUE(packShaderGrid(grid, &packed).ok());
    scale = std::bit_cast<float>(packed.words[4 * 3]);
    const ComputeDevice::Buffer words = device.makeBuffer(packed.words), box_buffer = device.makeBuffer(boxWords(box));
    image = device.makeImage({box.texel_count[0], box.texel_count[1], static_cast<uint32_t>(kSlabs) * box.texel_count[2]});
    using Binding = ComputeDevice::Binding;
    const ComputeDevice::Pass pass =
        device.makePass(spirv_path, {Binding::storage(words), Binding::uniform(box_buffer), Binding::written(image)});
    device.run(pass, boxGroups(box));
  }
};

// By texel kTexelNumbers numbers, in the order of slabs.
std::vector<float> numbersOf(const ComputeDevice& device, const Texture& texture) {
  const std::vector<uint32_t> words = device.texels(texture.image);
  const size_t count = texture.box.texelCount();
  std::vector<float> numbers(count * kTexelNumbers);
  for (size_t texel = 0; texel < count; ++texel) {
    for (size_t k = 0; k < kTexelNumbers; ++k) {
      const uint32_t pair = words[2 * (k / 4 * count + texel) + k % 4 / 2];
      numbers[kTexelNumbers * texel + k] = floatFromHalf({static_cast<uint16_t>(k % 2 == 0 ? pair & 0xffff : pair >> 16)});
    }
  }
  return numbers;
}

class ResampledOnVulkan : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    device_ = ComputeDevice::find();
    if (!device_) GTEST_SKIP() << "no Vulkan device, not even a software one (Debian: mesa-vulkan-drivers)";
  }
  void TearDown() override {
    if (!device_) return;
    for (const std::string& message : device_->messages()) ADD_FAILURE() << message;
  }
  std::optional<ComputeDevice> device_;
};

TEST_P(ResampledOnVulkan, HoldsWhatTheLibraryResamples) {
  for (const ThetaPrecision precision : {ThetaPrecision::int8, ThetaPrecision::float16}) {
    const Texture texture(*device_, everyRepresentation(precision, 7), GetParam());
    const std::vector<float> numbers = numbersOf(*device_, texture);
    int lit = 0, dark = 0;
    for (size_t texel = 0; texel < texture.box.texelCount(); ++texel) {
      const float* got = &numbers[kTexelNumbers * texel];
      const float* light = &texture.expected[kTexelNumbers * texel];
      ASSERT_NEAR(got[kShFloats], light[kShFloats], 1e-3f) << texel;
      ++(light[kShFloats] > 0.0f ? lit : dark);
      for (int k = 0; k < kShFloats; ++k) {
        // what the look-up may differ by, and a half that was rounded either way
        const float most = 1e-3f * std::max(1.0f, light[0]) + std::abs(light[k]) / 1024.0f;
        ASSERT_NEAR(got[k] * texture.scale, light[k], most) << texel << ", number " << k;
      }
    }
    EXPECT_GT(lit, 1000);
    EXPECT_GT(dark, 1000);
  }
}

// At centres of texels and halfway between: there filters weigh without rounding.
TEST_P(ResampledOnVulkan, LightsAsTheTexelsAroundDo) {
  const Texture texture(*device_, everyRepresentation(ThetaPrecision::int8, 7), GetParam());
  const std::vector<float> numbers = numbersOf(*device_, texture);
  constexpr size_t kPlaces = 64 * 64;
  Random random(8);
  std::vector<uint32_t> places;
  std::vector<float> expected, says;
  for (size_t i = 0; i < kPlaces; ++i) {
    std::array<uint32_t, 3> low, high;  // the texels of a place
    for (size_t axis = 0; axis < 3; ++axis) {
      const uint32_t count = texture.box.texel_count[axis], halves = random.below(2 * count + 1);
      low[axis] = halves == 0 ? 0 : std::min(count - 1, (halves - 1) / 2);
      high[axis] = std::min(count - 1, halves / 2);
      places.push_back(floatBits(halves / (2.0 * count)));
    }
    const std::array<float, 3> normal = randomNormal(random);
    places.push_back(0);
    for (const float value : normal) places.push_back(floatBits(value));
    places.push_back(0);
    std::array<float, kTexelNumbers> sum{};
    for (uint32_t corner = 0; corner < 8; ++corner) {
      const auto at = [&](uint32_t axis) { return size_t{corner >> axis & 1 ? high[axis] : low[axis]}; };
      const size_t texel = (at(2) * texture.box.texel_count[1] + at(1)) * texture.box.texel_count[0] + at(0);
      for (size_t k = 0; k < kTexelNumbers; ++k) sum[k] += 0.125f * numbers[kTexelNumbers * texel + k];
    }
    says.push_back(sum[kShFloats]);
    for (float value : flooredIrradiance(sum.data(), normal[0], normal[1], normal[2]))
      expected.push_back(sum[kShFloats] > 0.0f ? value / sum[kShFloats] : 0.0f);
  }
  using Binding = ComputeDevice::Binding;
  const ComputeDevice::Buffer place_buffer = device_->makeBuffer(places), lights = device_->makeBuffer(4 * kPlaces);
  const ComputeDevice::Pass pass = device_->makePass(
      NLG_RESAMPLED_SPIRV, {Binding::sampled(texture.image), Binding::storage(place_buffer), Binding::storage(lights)});
  device_->run(pass, {kPlaces / 64, 1, 1});
  const std::vector<uint32_t> got = lights.words();
  int lit = 0;
  for (size_t i = 0; i < kPlaces; ++i) {
    for (size_t c = 0; c < kShChannels; ++c) {
      const float value = expected[kShChannels * i + c];
      // a place is rounded to 2^-24 of the texture three times: 6e-5 of its 343 texels, of which the next may differ by 2^10, before
      // what they hold is divided by their say
      ASSERT_NEAR(std::bit_cast<float>(got[4 * i + c]), value, 1.0f / 16.0f / std::min(1.0f, says[i] > 0.0f ? says[i] : 1.0f))
          << i;
      lit += value > 0.0f;
    }
  }
  EXPECT_GT(lit, 1000);
}

INSTANTIATE_TEST_SUITE_P(Languages, ResampledOnVulkan, testing::Values(NLG_RESAMPLE_SPIRV, NLG_RESAMPLE_HLSL_SPIRV),
                         [](const auto& module) { return module.index == 0 ? "glsl" : "hlsl"; });

}  // namespace
}  // namespace nlg
