#include "export/engine/engine_format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "export/engine/ambient_cubes.h"
#include "export/engine/dds_file.h"
#include "export/engine/godot_format.h"
#include "export/engine/ktx2_file.h"
#include "export/engine/light_place.h"
#include "export/engine/sh_texture.h"
#include "runtime_eval/numbers/rgb9e5.h"
#include "tests/export/engine/godot_shader.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tool/base64.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

const LightVolume& sampleVolume() {
  static const LightVolume volume = [] {
    const LightGrid grid = everyRepresentation(ThetaPrecision::int8, 3);
    return makeLightVolume(grid, volumeBox(grid, {{"1", "101", "2", "17", "113", "21.5"}, 1.0}));
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

class EngineFormats : public testing::TestWithParam<std::string> {
 protected:
  const EngineFormat& format() const { return *findEngineFormat(GetParam()); }
};

TEST_P(EngineFormats, GiveBackTheIrradianceThatWasWritten) {
  const LightVolume& volume = sampleVolume();
  const LightBox& box = volume.box;
  const LightBox read_box = boxOfPlace("light.json", placeJson(box, format().texture_size(box.texel_count)).dump());
  const EngineIrradiance irradiance = format().read(format().write(volume), read_box);
  const bool is_cube = GetParam() == "bevy";
  Random random(1);
  int compared = 0;
  for (int i = 0; i < 5000; ++i) {
    const PositionM position_m = randomPlaceIn(box, random);
    std::array<float, 3> normal = randomNormal(random);
    if (is_cube) {
      // a cube holds what planes see that face the axes
      const uint32_t side = random.below(6);
      normal = {};
      normal[side / 2] = side % 2 == 0 ? 1.0f : -1.0f;
    }
    const PositionM read_m = readAt(GetParam(), box, position_m, normal);
    bool is_inside = true;
    for (size_t axis = 0; axis < 3; ++axis)
      is_inside = is_inside && read_m[axis] > box.low_m[axis] && read_m[axis] < box.high_m[axis];
    if (!is_inside) continue;
    const std::array<float, kShFloats> light = interpolate(volume, read_m);
    const std::array<float, 3> exact = shIrradiance(light.data(), normal[0], normal[1], normal[2]);
    const std::array<float, 3> shown = irradiance(position_m, normal.data());
    // Coefficients of this grid are 4 at most, 0.3 where they are not the mean's, and float16 halves of a 2^-11: of Y00, of three of
    // order 1 and of five of order 2 with what irradiance takes of each. RGB9E5: 2^-9 of the largest channel, which is 1.6.
    const float bound = is_cube ? 0x1p-9f * 2.0f * kPi : 0x1p-11f * (0.887f * 4 + 0.3f * (1.024f * 1.74f + 0.86f * 3)) + 1e-5f;
    for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(shown[c], std::max(0.0f, exact[c]), bound) << i << ", channel " << c;
    ++compared;
  }
  EXPECT_GT(compared, 4000);
}

TEST_P(EngineFormats, SayTheirTexturesSize) {
  const TextureSize box = sampleVolume().box.texel_count;
  EXPECT_EQ(box, (TextureSize{16, 12, 20}));
  const TextureSize expected = GetParam() == "bevy" ? TextureSize{16, 24, 60} : TextureSize{16, 12, 7 * 22};
  EXPECT_EQ(format().texture_size(box), expected);
}

TEST_P(EngineFormats, AreWrittenTheSameAgain) {
  const std::vector<EngineFile> first = format().write(sampleVolume()), second = format().write(sampleVolume());
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(first[i].bytes == second[i].bytes) << first[i].name;
}

TEST_P(EngineFormats, RefuseTexturesThatAreCutShortOrOfAnotherBox) {
  std::vector<EngineFile> files = format().write(sampleVolume());
  LightBox other = sampleVolume().box;
  ++other.texel_count[1];
  EXPECT_THROW(format().read(files, other), InputError);
  EXPECT_THROW(format().read({}, sampleVolume().box), InputError);
  for (const size_t kept : {size_t{0}, size_t{17}, size_t{200}, files[0].bytes.size() / 2}) {
    std::vector<EngineFile> cut = files;
    cut[0].bytes.resize(kept);
    EXPECT_THROW(format().read(cut, sampleVolume().box), InputError) << kept;
  }
}

INSTANTIATE_TEST_SUITE_P(All, EngineFormats, testing::Values("three", "bevy", "godot", "ktx2-sh", "dds-sh"),
                         [](const auto& format) {
                           std::string name = format.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(EngineFormat, KnowsNoOtherNames) {
  EXPECT_EQ(findEngineFormat("unity"), nullptr);
  EXPECT_EQ(findEngineFormat("c-header"), nullptr) << "nothing of it is resampled";
  EXPECT_EQ(engineFormats().size(), 5u);
}

// One texel: red has a mean of 4 and 1 along x, green 2 along -y and no mean, blue a mean of 1.
TEST(AmbientCubes, HoldIrradianceOverPiOfTheSixSides) {
  LightVolume volume{{{0, 0, 0}, {1, 1, 1}, {1, 1, 1}}, std::vector<float>(kShFloats)};
  volume.light[0] = 4.0f, volume.light[2] = 1.0f;  // Y00
  volume.light[3 * 3 + 0] = 1.0f;                  // Y11: x
  volume.light[1 * 3 + 1] = -2.0f;                 // Y1-1: y
  const Texture3d texture = textureOfRgb9e5(packAmbientCubes(volume), ambientCubesSize(volume.box.texel_count));
  EXPECT_EQ(texture.size, (TextureSize{1, 2, 3}));
  // Y00 is 0.28209 in every direction, Y11 0.48860 along x; irradiance over pi takes 1 and 2 / 3 of them
  const float mean = 4 * 0.28209479f, along = 0.48860251f * 2 / 3, blue = 0.28209479f, half_step = 0x1p-9f;
  const float expected[6][3] = {{mean + along, 0, blue}, {mean - along, 0, blue}, {mean, 0, blue},
                                {mean, 2 * along, blue}, {mean, 0, blue},         {mean, 0, blue}};
  for (size_t side = 0; side < 6; ++side) {
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(texture.texels[side][c], expected[side][c], 2 * half_step) << side << ", " << c;
  }
}

TEST(AmbientCubes, AreDarkOutsideTheirBox) {
  const LightVolume& volume = sampleVolume();
  const Texture3d texture = textureOfRgb9e5(packAmbientCubes(volume), ambientCubesSize(volume.box.texel_count));
  const float normal[3] = {0.0f, 1.0f, 0.0f};
  PositionM position_m = volume.box.high_m;
  EXPECT_GT(ambientCubesIrradiance(texture, volume.box, position_m, normal)[0], 0.0f);
  position_m[0] += 1e-6;
  EXPECT_EQ(ambientCubesIrradiance(texture, volume.box, position_m, normal)[0], 0.0f);
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

TEST(Ktx2File, GivesBackWhatItWasGiven) {
  Ktx2Texture texture{Ktx2Format::rgb9e5, {3, 2, 1}, std::string(24, 'x'), {{"KTXwriter", "test"}, {"empty", ""}}};
  const Ktx2Texture read = parseKtx2("a.ktx2", ktx2Bytes(texture));
  EXPECT_EQ(read.format, texture.format);
  EXPECT_EQ(read.size, texture.size);
  EXPECT_EQ(read.texels, texture.texels);
  EXPECT_EQ(read.texts, texture.texts);
}

TEST(Ktx2File, RefusesEveryTruncationAndTakesNoOtherNumberOfTexels) {
  const std::string bytes = ktx2Bytes({Ktx2Format::rgba16f, {2, 1, 2}, std::string(32, 'x'), {{"key", "value"}}});
  for (size_t kept = 0; kept < bytes.size(); ++kept) EXPECT_THROW(parseKtx2("a.ktx2", bytes.substr(0, kept)), InputError) << kept;
  for (size_t place = 0; place < bytes.size(); ++place) {
    for (const char changed : {'\0', '\x7f', '\xff'}) {
      std::string damaged = bytes;
      damaged[place] = changed;
      try {
        const Ktx2Texture read = parseKtx2("a.ktx2", damaged);
        const uint64_t texel_bytes = read.format == Ktx2Format::rgba16f ? 8 : 4;
        ASSERT_EQ(read.texels.size(), uint64_t{read.size[0]} * read.size[1] * read.size[2] * texel_bytes) << place;
      } catch (const InputError&) {
      }
    }
  }
}

TEST(DdsFile, RefusesEveryTruncationAndEveryOtherHeader) {
  const std::string bytes = ddsBytes({2, 1, 2}, std::string(32, 'x'));
  EXPECT_EQ(parseDds("a.dds", bytes).texels, std::string(32, 'x'));
  for (size_t kept = 0; kept < bytes.size(); ++kept) EXPECT_THROW(parseDds("a.dds", bytes.substr(0, kept)), InputError) << kept;
  for (size_t place = 0; place < 148; ++place) {
    std::string damaged = bytes;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x55);
    EXPECT_THROW(parseDds("a.dds", damaged), InputError) << place;
  }
}

TEST(LightPlace, GivesBackItsBoxToTheLastBit) {
  const LightBox box{{-0.1, 1e-7, 12345.678901234567}, {0.3, 2e-7, 123456.7890123}, {1, 2, 3}};
  const LightBox read = boxOfPlace("light.json", placeJson(box, {1, 2, 35}).dump());
  EXPECT_EQ(read.low_m, box.low_m);
  EXPECT_EQ(read.high_m, box.high_m);
  EXPECT_EQ(read.texel_count, box.texel_count);
  for (const char* bad :
       {"", "{}", "[]", R"({"low_m":[0,0,0],"high_m":[1,0,1],"resolution":[1,1,1]})",
        R"({"low_m":[0,0],"high_m":[1,1,1],"resolution":[1,1,1]})", R"({"low_m":[0,0,0],"high_m":[1,1,1],"resolution":[1,1,0]})"})
    EXPECT_THROW(boxOfPlace("light.json", bad), InputError) << bad;
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
  for (const char* bad : {"Zg", "Zg=", "Z===", "Zm9v!mFy"}) EXPECT_FALSE(fromBase64(bad, &read)) << bad;
}

TEST(GodotShader, ShowsWhatTheReaderShows) {
  const LightVolume& volume = sampleVolume();
  const Texture3d texture = textureOfHalves(packShTexture(volume), shTextureSize(volume.box.texel_count));
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    PositionM position_m = randomPlaceIn(volume.box, random);
    if (i % 4 == 0) position_m[2] += 30.0;
    const std::array<float, 3> normal = randomNormal(random);
    const std::array<float, 3> expected = shTextureIrradiance(texture, volume.box, position_m, normal.data());
    const std::array<double, 3> shown = godotShaderIrradiance(texture, volume.box, position_m, normal);
    for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(shown[c], expected[c], 1e-5 * std::max(1.0f, expected[c])) << i;
  }
}

TEST(GodotShader, HasTheBoxBeforeItsFunction) {
  const LightVolume volume{{{-1, 0.5, 0}, {3, 2, 1e20}, {1, 1, 2}}, std::vector<float>(2 * kShFloats)};
  const std::string text = fileNamed(godotFiles(volume), "light.gdshaderinc");
  const size_t function = text.find("vec3 nlg_irradiance(");
  for (const char* line :
       {"uniform sampler3D nlg_light : filter_linear, repeat_disable;\n", "const vec3 NLG_LOW_M = vec3(-1.0, 0.5, 0.0);\n",
        "const vec3 NLG_HIGH_M = vec3(3.0, 2.0, 1e+20);\n", "const vec3 NLG_RESOLUTION = vec3(1.0, 1.0, 2.0);\n"})
    EXPECT_LT(text.find(line), function) << line;
}

}  // namespace
}  // namespace nlg
