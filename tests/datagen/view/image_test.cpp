#include "datagen/view/image.h"

#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <filesystem>

#include "datagen/view/legend.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

// How much of the picture has been covered by black on white, in pixels.
double inkOf(const Image& image) {
  double ink = 0.0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) ink += 1.0 - image.at(x, y).g / 255.0;
  }
  return ink;
}

std::string temporaryPath(const std::string& name) {
  return (std::filesystem::temp_directory_path() / (std::to_string(getpid()) + "." + name)).string();
}

TEST(Image, LinesCoverTheirLengthTimesWidthAtAnySlope) {
  for (const glm::dvec2& end : {glm::dvec2(180.3, 20.1), {20.0, 175.5}, {150.2, 120.7}, {170.0, 21.0}}) {
    Image image(200, 200, kWhite);
    const glm::dvec2 start(20.2, 20.4);
    drawLine(image, start, end, 3.0, kBlack);
    // a stroke with half a disc at both ends; the smooth edge is symmetric about the true one, but for rounding and round ends
    const double expected = 3.0 * glm::length(end - start) + 3.14159 * 1.5 * 1.5;
    EXPECT_NEAR(inkOf(image), expected, 0.01 * expected) << end.x << ", " << end.y;
  }
}

TEST(Image, DiscsAndRingsCoverTheirArea) {
  Image disc(64, 64, kWhite), ring(64, 64, kWhite);
  drawDisc(disc, {31.3, 32.8}, 20.0, kBlack);
  drawRing(ring, {31.3, 32.8}, 20.0, 4.0, kBlack);
  EXPECT_NEAR(inkOf(disc), 3.14159265 * 400, 3.14159265 * 400 * 0.005);
  EXPECT_NEAR(inkOf(ring), 2 * 3.14159265 * 20 * 4, 2 * 3.14159265 * 20 * 4 * 0.005);
}

TEST(Image, CutsOffWhatLiesOutside) {
  Image image(10, 10, kWhite);
  fillRect(image, -5, -5, 8, 8, kBlack);
  EXPECT_EQ(image.at(2, 2), kBlack);
  EXPECT_EQ(image.at(3, 3), kWhite);
  drawLine(image, {-1e12, 8.5}, {1e12, 8.5}, 1.0, kBlack);
  for (int x = 0; x < 10; ++x) EXPECT_EQ(image.at(x, 8), kBlack) << x;
  EXPECT_EQ(image.at(5, 6), kWhite);
  drawLine(image, {-100, -50}, {-50, -100}, 3.0, kBlack);
  drawText(image, 8, 8, "outside", kBlack);
  drawDisc(image, {1e9, -1e9}, 5.0, kBlack);
}

TEST(Image, HalvedIsTheMeanOfFour) {
  Image image(2, 2, kWhite);
  image.set(0, 0, {0, 100, 255});
  EXPECT_EQ(halved(image).at(0, 0), (Colour{191, 216, 255}));  // (3 * 255 + 0) / 4 = 191.25, (3 * 255 + 100) / 4 = 216.25
}

TEST(ColourMap, RisesInLightness) {
  double before = lightness(phiColour(0.0));
  EXPECT_EQ(before, 0.0);
  for (int i = 1; i <= 255; ++i) {
    const double now = lightness(phiColour(i / 255.0));
    // two 8-bit colours next to each other may be the same or differ by rounding: one step of green is 0.4 at most
    EXPECT_GT(now, before - 0.4) << i;
    if (i % 8 == 0) {
      EXPECT_GT(now, lightness(phiColour((i - 7) / 255.0))) << i;
    }
    before = now;
  }
  EXPECT_GT(before, 90.0);
}

TEST(PngFile, DecodesToTheSamePixels) {
  Image image(37, 21, kWhite);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) image.set(x, y, {static_cast<uint8_t>(7 * x), static_cast<uint8_t>(12 * y), 99});
  }
  const std::string path = temporaryPath("pixels.png");
  writePng(path, image);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  EXPECT_EQ(header.width, 37u);
  EXPECT_EQ(header.height, 21u);
  header.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> bytes(PNG_IMAGE_SIZE(header));
  ASSERT_NE(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr), 0) << header.message;
  EXPECT_EQ(bytes, image.bytes());
  const std::string first = readFile(path);
  writePng(path, image);
  EXPECT_EQ(readFile(path), first);
  EXPECT_EQ(first.find("tIME"), std::string::npos);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace nlg
