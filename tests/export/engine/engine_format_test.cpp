#include "export/engine/engine_format.h"

#include <gtest/gtest.h>

#include <cmath>

#include "export/engine/light_volume.h"
#include "runtime_eval/numbers/rgb9e5.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tool/base64.h"
#include "tool/error.h"

namespace nlg {
namespace {

const LightVolume& sampleVolume() {
  static const LightVolume volume = [] {
    const LightBox box = texelBox({1, 101, 2}, {17, 113, 21.5}, 1.0);
    LookUpScratch scratch;
    ResampledLight light = resampleLight(everyRepresentation(ThetaPrecision::int8, 3), box, &scratch);
    std::vector<uint8_t> is_lit(light.status.size());
    std::transform(light.status.begin(), light.status.end(), is_lit.begin(),
                   [](LightStatus status) { return status == LightStatus::lit; });
    return filledVolume(box, std::move(light.light), is_lit);
  }();
  return volume;
}

// Coefficients between texels, interpolated without any texture; what a shader must show of them.
std::array<float, kShFloats> interpolate(const LightVolume& volume, const PositionM& position_m) {
  std::array<size_t, 3> low;
  std::array<double, 3> share;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double count = volume.box.texel_count[axis];
    const double at =
        (position_m[axis] - volume.box.low_m[axis]) / (volume.box.high_m[axis] - volume.box.low_m[axis]) * count - 0.5;
    low[axis] = static_cast<size_t>(std::clamp(std::floor(at), 0.0, count - 2));
    share[axis] = std::clamp(at - static_cast<double>(low[axis]), 0.0, 1.0);
  }
  std::array<float, kShFloats> light{};
  for (size_t corner = 0; corner < 8; ++corner) {
    double part = 1.0;
    std::array<size_t, 3> texel;
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t high = corner >> axis & 1;
      part *= high ? share[axis] : 1.0 - share[axis];
      texel[axis] = low[axis] + high;
    }
    const size_t index = (texel[2] * volume.box.texel_count[1] + texel[1]) * volume.box.texel_count[0] + texel[0];
    for (size_t i = 0; i < kShFloats; ++i) light[i] += static_cast<float>(part * volume.light[index * kShFloats + i]);
  }
  return light;
}

PositionM randomPlaceIn(const LightBox& box, Random& random) {
  PositionM position_m;
  for (size_t axis = 0; axis < 3; ++axis) position_m[axis] = random.uniform(box.low_m[axis], box.high_m[axis]);
  return position_m;
}

// Where a format's shader reads, of where the pixel stands.
PositionM readAt(const std::string& format, const LightBox& box, const PositionM& position_m,
                 const std::array<float, 3>& normal) {
  PositionM read_m = position_m;
  if (format != "three") return read_m;
  for (size_t axis = 0; axis < 3; ++axis)
    read_m[axis] += 0.5 * normal[axis] * (box.high_m[axis] - box.low_m[axis]) / box.texel_count[axis];
  return read_m;
}

class TextureFormats : public testing::TestWithParam<size_t> {
 protected:
  const TextureFormat& format() const { return textureFormats()[GetParam()]; }
};

TEST_P(TextureFormats, ShowTheIrradianceOfTheirTexels) {
  const LightVolume& volume = sampleVolume();
  const LightBox& box = volume.box;
  const EngineIrradiance irradiance = format().shown(textureOfHalves(packShTexture(volume), shTextureSize(box.texel_count)), box);
  Random random(1);
  int compared = 0, at_floor = 0;
  for (int i = 0; i < 5000; ++i) {
    const PositionM position_m = randomPlaceIn(box, random);
    const std::array<float, 3> normal = randomNormal(random);
    const PositionM read_m = readAt(format().name, box, position_m, normal);
    bool is_inside = true;
    for (size_t axis = 0; axis < 3; ++axis)
      is_inside = is_inside && read_m[axis] > box.low_m[axis] && read_m[axis] < box.high_m[axis];
    if (!is_inside) continue;
    const std::array<float, kShFloats> light = interpolate(volume, read_m);
    std::array<float, 3> exact = shIrradiance(light.data(), normal[0], normal[1], normal[2]);
    const std::array<float, 3> floored = flooredIrradiance(light.data(), normal[0], normal[1], normal[2]);
    for (size_t c = 0; c < 3; ++c) at_floor += exact[c] < floored[c];
    if (std::string(format().name) == "ktx2-sh") exact = floored;  // three.js has no floor
    const std::array<float, 3> shown = irradiance(position_m, normal.data());
    // Coefficients of this grid are 4 at most, 2 where they are not the mean's, and float16 halves of a 2^-11: of Y00, of three of
    // order 1 and of five of order 2 with what irradiance takes of each.
    const float bound = 0x1p-11f * (0.887f * 4 + 2 * (1.024f * 1.74f + 0.86f * 3)) + 1e-5f;
    for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(shown[c], std::max(0.0f, exact[c]), bound) << i << ", channel " << c;
    ++compared;
  }
  EXPECT_GT(compared, 4000);
  EXPECT_GT(at_floor, 100);
}

INSTANTIATE_TEST_SUITE_P(All, TextureFormats, testing::Values(size_t{0}, size_t{1}),
                         [](const auto& format) { return format.param == 0 ? "three" : "ktx2_sh"; });

TEST(ShTexture, HoldsSevenVolumesWithASliceMoreAtBothEnds) {
  EXPECT_EQ(sampleVolume().box.texel_count, (TextureSize{16, 12, 20}));
  EXPECT_EQ(shTextureSize({16, 12, 20}), (TextureSize{16, 12, 7 * 22}));
  EXPECT_EQ(packShTexture(sampleVolume()).size(), size_t{8} * 16 * 12 * 7 * 22);
}

// As Vulkan has it: 9 bits a channel times 2^(exponent - 24).
std::array<float, 3> floatsFromRgb9e5(uint32_t bits) {
  std::array<float, 3> rgb;
  for (int c = 0; c < 3; ++c)
    rgb[static_cast<size_t>(c)] = std::ldexp(static_cast<float>(bits >> 9 * c & 511), static_cast<int>(bits >> 27) - 24);
  return rgb;
}

TEST(Rgb9e5, RoundsToNearestAndSharesTheLargestExponent) {
  EXPECT_EQ(rgb9e5FromFloats({0.0f, 0.0f, 0.0f}), 0u);
  EXPECT_EQ(rgb9e5FromFloats({1.0f, 0.5f, 0.25f}), 256u | 128u << 9 | 64u << 18 | 16u << 27);
  EXPECT_EQ(rgb9e5FromFloats({kMaxRgb9e5, 0.0f, 0.0f}), 511u | 31u << 27);
  EXPECT_EQ(floatsFromRgb9e5(rgb9e5FromFloats({511.6f, 1.0f, 0.0f}))[0], 512.0f) << "rounded up to the next power of two";
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    std::array<float, 3> rgb;
    for (float& channel : rgb) channel = static_cast<float>(std::exp2(random.uniform(-20.0, 15.9)));
    const std::array<float, 3> read = floatsFromRgb9e5(rgb9e5FromFloats(rgb));
    const float largest = std::max({rgb[0], rgb[1], rgb[2]});
    for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(read[c], rgb[c], std::max(0x1p-9f * largest, 0x1p-25f)) << i;
    ASSERT_EQ(rgb9e5FromFloats(read), rgb9e5FromFloats(rgb)) << i;
  }
}

TEST(Base64, IsThatOfTheStandard) {
  const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : vectors) {
    EXPECT_EQ(base64(bytes), text);
    std::string read;
    EXPECT_TRUE(fromBase64(text, &read));
    EXPECT_EQ(read, bytes);
  }
  std::string read;
  for (const char* bad : {"Z", "Z===", "Zg===", "Zg==Zg", "Zm9v!mFy"}) EXPECT_FALSE(fromBase64(bad, &read)) << bad;
}

}  // namespace
}  // namespace nlg
