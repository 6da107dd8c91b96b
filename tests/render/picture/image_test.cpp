#include "render/picture/image.h"

#include <gtest/gtest.h>
#include <png.h>

#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"

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

TEST(PngFile, DecodesToTheSamePixels) {
  Image image(37, 21, kWhite);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) image.set(x, y, {static_cast<uint8_t>(7 * x), static_cast<uint8_t>(12 * y), 99});
  }
  const TemporaryFolder folder;
  const std::string path = folder / "pixels.png";
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
}

}  // namespace
}  // namespace nlg
