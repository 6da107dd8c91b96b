#include "scene/model/sky_image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scene/image/sky_file.h"
#include "scene/lights/light_options.h"
#include "scene/model/scene_light.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kPi = 3.141592653589793;

SkyImage imageOf(int width, const glm::vec3& colour) {
  return {width, width / 2, std::vector<glm::vec3>(static_cast<size_t>(width) * width / 2, colour)};
}

glm::dvec3 fluxOf(const SkyImage& image) {
  glm::dvec3 flux(0.0);
  for (size_t i = 0; i < image.texels.size(); ++i)
    flux += image.solidAngle(static_cast<int>(i / image.width)) * glm::dvec3(image.texels[i]);
  return flux;
}

TEST(SkyImage, LooksAlongXInItsMiddleAndTowardsZOnTheRight) {
  EXPECT_LT(glm::length(skyDirection(0.5, 0.5) - glm::vec3(1, 0, 0)), 1e-6f);
  EXPECT_LT(glm::length(skyDirection(0.75, 0.5) - glm::vec3(0, 0, 1)), 1e-6f);
  EXPECT_LT(glm::length(skyDirection(0.3, 0.0) - glm::vec3(0, 1, 0)), 1e-6f);
  for (const double column : {0.01, 0.3, 0.99}) {
    for (const double row : {0.02, 0.5, 0.97}) {
      const glm::vec2 place = skyPlace(skyDirection(column, row));
      EXPECT_NEAR(place.x, column, 1e-6) << row;
      EXPECT_NEAR(place.y, row, 1e-6) << column;
    }
  }
  SkyImage image = imageOf(8, glm::vec3(0.0f));
  image.texels[1 * 8 + 6] = glm::vec3(1, 2, 3);  // right of the middle by a quarter turn and a half texel, above the horizon
  EXPECT_EQ(image.radiance({-0.3f, 0.4f, 1.0f}), glm::vec3(1, 2, 3));
  EXPECT_EQ(image.radiance({-0.3f, -0.4f, 1.0f}), glm::vec3(0.0f));
  EXPECT_EQ(image.radiance({0.3f, 0.4f, -1.0f}), glm::vec3(0.0f));
}

TEST(SkyReduction, LosesNoLightWhateverTheSizeAndTheTurn) {
  for (const int height : {3, 128, 512, 700, 1050}) {
    for (const double turn : {0.0, 0.25, -0.37, 1.0}) {
      const int width = 2 * height;
      SkyReduction reduction(width, height, turn);
      glm::dvec3 flux(0.0);
      std::vector<float> row(3 * static_cast<size_t>(width));
      for (int y = 0; y < height; ++y) {
        const double solid_angle = 2.0 * kPi / width * (std::cos(kPi * y / height) - std::cos(kPi * (y + 1.0) / height));
        for (int x = 0; x < width; ++x) {
          for (int c = 0; c < 3; ++c) row[3 * static_cast<size_t>(x) + c] = static_cast<float>((x * 7 + y * 13 + c * 5) % 31);
          flux += solid_angle * glm::dvec3(row[3 * static_cast<size_t>(x)], row[3 * static_cast<size_t>(x) + 1],
                                           row[3 * static_cast<size_t>(x) + 2]);
        }
        reduction.addRow(y, row.data());
      }
      const SkyImage image = reduction.finish();
      EXPECT_LE(image.width, kMostSkyColumns);
      EXPECT_LE(image.height, kMostSkyRows);
      // texels are floats: half a unit of the last place each
      const glm::dvec3 got = fluxOf(image);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], flux[c], 1e-6 * flux[c]) << height << " " << turn;
    }
  }
}

TEST(SkyReduction, TurnsFromXTowardsZ) {
  SkyReduction reduction(8, 4, 0.25);
  std::vector<float> dark(24, 0.0f), bright(24, 0.0f);
  bright[3 * 4] = 5.0f;  // right of the middle: towards +x
  for (int y = 0; y < 4; ++y) reduction.addRow(y, y == 1 ? bright.data() : dark.data());
  const SkyImage image = reduction.finish();
  EXPECT_NEAR(image.radiance(skyDirection(0.5625 + 0.25, 0.375)).r, 5.0f, 1e-5f);
}

TEST(TakeSun, FindsADiscWithItsLightAndLeavesTheSkyWithoutIt) {
  SkyImage image = imageOf(1024, glm::vec3(1.0f, 2.0f, 3.0f));
  const glm::vec3 to_sun = skyDirection(0.62, 0.3);
  glm::dvec3 flux(0.0);
  for (size_t i = 0; i < image.texels.size(); ++i) {
    const int row = static_cast<int>(i / 1024);
    const glm::vec3 direction = skyDirection((i % 1024 + 0.5) / 1024, (row + 0.5) / 512);
    if (glm::dot(direction, to_sun) < std::cos(0.02)) continue;
    image.texels[i] += glm::vec3(4000.0f, 3000.0f, 2000.0f);
    flux += image.solidAngle(row) * glm::dvec3(4000.0, 3000.0, 2000.0);
  }
  const std::optional<Sun> sun = takeSun(&image);
  ASSERT_TRUE(sun.has_value());
  EXPECT_GT(glm::dot(sun->to_sun, to_sun), std::cos(0.003)) << "half a texel";
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sun->irradiance[c], flux[c], 1e-3 * flux[c]);
  EXPECT_NEAR(sun->angular_radius, 0.02f, 0.003f);
  for (const glm::vec3& texel : image.texels) EXPECT_LT(glm::length(texel - glm::vec3(1, 2, 3)), 1e-4f);
}

TEST(TakeSun, LeavesSkiesWithoutASunAsTheyAre) {
  SkyImage half = imageOf(256, glm::vec3(1.0f));
  for (size_t i = 0; i < half.texels.size() / 2; ++i) half.texels[i] = glm::vec3(10.0f);
  const SkyImage before = half;
  EXPECT_FALSE(takeSun(&half).has_value());
  EXPECT_EQ(half.texels, before.texels);
  SkyImage black = imageOf(256, glm::vec3(0.0f));
  EXPECT_FALSE(takeSun(&black).has_value());
  SkyImage tiny = imageOf(2, glm::vec3(1.0f));
  EXPECT_FALSE(takeSun(&tiny).has_value());
}

// A picture of 8 x 4 pixels in Radiance's format; every row the same.
std::string hdr(const std::string& row, const std::string& sides = "-Y 4 +X 8",
                const std::string& head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n") {
  return head + sides + "\n" + row + row + row + row;
}
// Pixels of 1, 2, 3 (exponent 2: times 2^(130-136)), the last one of them 0.
std::string plainRow() {
  std::string row;
  for (int x = 0; x < 7; ++x) row += {64, static_cast<char>(128), static_cast<char>(192), static_cast<char>(130)};
  return row + std::string(4, '\0');
}
std::string packedRow() {
  std::string row{2, 2, 0, 8};
  for (const int value : {64, 128, 192, 130}) {
    row += {static_cast<char>(128 + 6), static_cast<char>(value)};  // a run of six
    row += {2, static_cast<char>(value), 0};                        // and two plain ones
  }
  return row;
}
std::string oldRow() {
  return std::string{64, static_cast<char>(128), static_cast<char>(192), static_cast<char>(130), 1, 1, 1, 6} +
         std::string(4, '\0');
}

class SkyFiles : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

TEST_F(SkyFiles, AllThreeFormsOfRadianceGiveTheSameImage) {
  for (const std::string& row : {plainRow(), packedRow(), oldRow()}) {
    const SkyFile file = readSkyFile(folder_.write("sky.HDR", hdr(row)), 0.0);
    ASSERT_EQ(file.image.width, 8);
    ASSERT_EQ(file.image.height, 4);
    EXPECT_EQ(file.mended, 0u);
    for (size_t i = 0; i < file.image.texels.size(); ++i)
      EXPECT_EQ(file.image.texels[i], i % 8 == 7 ? glm::vec3(0.0f) : glm::vec3(1, 2, 3)) << i;
  }
}

std::string exr(const TemporaryFolder& folder, const std::vector<const char*>& channels, const std::vector<float>& values,
                int width) {
  const std::string path = folder.write("sky.exr", "");
  const int height = static_cast<int>(values.size()) / width;
  // a window that does not begin at 0
  const Imath::Box2i window({3, -5}, {3 + width - 1, -5 + height - 1});
  Imf::Header header(window, window);
  Imf::FrameBuffer buffer;
  char* origin =
      reinterpret_cast<char*>(const_cast<float*>(values.data())) - (3 - 5 * width) * static_cast<std::ptrdiff_t>(sizeof(float));
  for (const char* channel : channels) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    buffer.insert(channel, Imf::Slice(Imf::FLOAT, origin, sizeof(float), sizeof(float) * static_cast<size_t>(width)));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
  return path;
}

TEST_F(SkyFiles, OpenExrKeepsSunsThatHalfCannotHoldAndCountsWhatIsNoRadiance) {
  std::vector<float> values(16 * 8, 0.5f);
  values[0] = 1e6f;
  values[17] = -1.0f;
  values[18] = std::numeric_limits<float>::quiet_NaN();
  values[19] = std::numeric_limits<float>::infinity();
  const SkyFile file = readSkyFile(exr(folder_, {"A", "B", "G", "R"}, values, 16), 0.0);
  EXPECT_EQ(file.mended, 9u);
  for (size_t i = 0; i < values.size(); ++i)
    EXPECT_EQ(file.image.texels[i], glm::vec3(i >= 17 && i <= 19 ? 0.0f : values[i])) << i;
  EXPECT_EQ(readSkyFile(exr(folder_, {"Y"}, values, 16), 0.0).image.texels, file.image.texels);
}

TEST_F(SkyFiles, AnImageIsTheSkyByOptionTurnedAndScaled) {
  const std::string path = folder_.write("sky.hdr", hdr(plainRow()));
  Scene scene = wallWithHole();
  LightOptions options;
  options.sky = {path};
  EXPECT_EQ(applyLight(scene, options).size(), 1u);
  EXPECT_EQ(scene.light.sky.radiance({1, 0.1f, 0}), glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.light.sky.radiance({-1, 0.1f, -0.1f}), glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.light.sky.radiance({-1, 0.1f, 0.1f}), glm::vec3(0.0f)) << "the last column";
  const std::string plain = sceneLightSha256(scene);
  options.sky = {path, "90", "2"};
  applyLight(scene, options);
  EXPECT_EQ(scene.light.sky.radiance({1, 0.1f, 0}), glm::vec3(2, 4, 6));
  EXPECT_EQ(scene.light.sky.radiance({-0.1f, 0.1f, -1}), glm::vec3(0.0f)) << "a quarter turn from x towards z";
  EXPECT_NE(sceneLightSha256(scene), plain);
  const std::vector<std::vector<std::string>> wrong = {{path, "x"}, {path, "400"}, {path, "0", "-1"}, {path, "0", "1", "1"}};
  for (const std::vector<std::string>& sky : wrong) EXPECT_THROW(applyLight(scene, {sky, {}}), UsageError) << sky.back();
}

TEST_F(SkyFiles, TheSunOfAnImageIsASunUnlessAnotherIsGiven) {
  std::vector<float> values(256 * 128, 0.1f);
  values[32 * 256 + 128] = 1e5f;  // the middle of the texel: 44.3 degrees high, .7 right of +x
  const std::string path = exr(folder_, {"R", "G", "B"}, values, 256);
  Scene scene = wallWithHole();
  LightOptions options;
  options.sky = {path};
  const std::vector<std::string> done = applyLight(scene, options);
  ASSERT_EQ(done.size(), 2u);
  EXPECT_NE(done[1].find("azimuth 1, elevation 44 degrees"), std::string::npos) << done[1];
  ASSERT_EQ(scene.light.suns.size(), 1u);
  EXPECT_NEAR(scene.light.suns[0].irradiance.r, 1e5 * scene.light.sky.image.solidAngle(32), 0.1);
  EXPECT_LT(scene.light.sky.radiance(scene.light.suns[0].to_sun).r, 0.11f) << "it is no longer in the image";
  options.sun = {"0"};
  applyLight(scene, options);
  EXPECT_TRUE(scene.light.suns.empty());
  // beside a sun of the file's, which keeps its group
  Scene with_sun = wallWithHole();
  with_sun.light.suns = {defaultSun()};
  with_sun.light.sun_labels = {{"Noon", "day"}};
  options.sun.clear();
  options.light_groups = "name";
  EXPECT_NE(applyLight(with_sun, options)[1].find("beside those of the scene"), std::string::npos);
  EXPECT_EQ(with_sun.light.groups.names, (std::vector<std::string>{"sky", "day", "sun"}));
  EXPECT_EQ(with_sun.light.groups.of_sun, (std::vector<uint8_t>{1, 2}));
}

}  // namespace
}  // namespace nlg
