#include "scene/image/image_decode.h"

#include <gtest/gtest.h>

#include <array>

#include "scene/image/image_loader.h"
#include "tests/scene/image/hand_built_images.h"

namespace nlg {
namespace {

constexpr uint64_t kMany = uint64_t{1} << 40;

DecodedImage decoded(const std::string& bytes) {
  PixelWork work(kMany);
  DecodedImage image;
  EXPECT_EQ(decodeImage(bytes, work, &image), "");
  return image;
}

std::string pixelsOf(const DecodedImage& image) { return {image.pixels.begin(), image.pixels.end()}; }

// A PNG of the bytes that its rows hold before packing, without compression.
struct PngRows {
  int width, height, bits, colour_type, interlace;
  std::string rows;
  std::string palette, opacity;
};

std::string packedPng(const PngRows& rows) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp to, png_bytep data, size_t count) {
        static_cast<std::string*>(png_get_io_ptr(to))->append(reinterpret_cast<char*>(data), count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(rows.width), static_cast<png_uint_32>(rows.height), rows.bits,
               rows.colour_type, rows.interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  std::string palette = rows.palette, opacity = rows.opacity, data = rows.rows;
  if (!palette.empty())
    png_set_PLTE(png, info, reinterpret_cast<png_colorp>(palette.data()), static_cast<int>(palette.size() / 3));
  if (!opacity.empty())
    png_set_tRNS(png, info, reinterpret_cast<png_bytep>(opacity.data()), static_cast<int>(opacity.size()), nullptr);
  png_write_info(png, info);
  const size_t stride = data.size() / static_cast<size_t>(rows.height);
  const int passes = png_set_interlace_handling(png);
  for (int pass = 0; pass < passes; ++pass) {
    for (int y = 0; y < rows.height; ++y)
      png_write_row(png, reinterpret_cast<png_bytep>(data.data() + stride * static_cast<size_t>(y)));
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

const std::string kFour("\x01\x02\x03\xff\x10\x20\x30\x80\xff\x00\x00\x00\xff\xff\xff\x01", 16);

TEST(ImageDecode, PngAndWebpGivePixelsAsTheyAre) {
  for (const std::string& bytes : {png(2, 2, kFour), webp(2, 2, kFour)}) {
    const DecodedImage image = decoded(bytes);
    EXPECT_EQ(image.width, 2);
    ASSERT_EQ(image.pixels.size(), 16u);
    for (size_t at = 0; at < 16; ++at) {
      // WebP leaves the colour of what is not there open
      if (at < 8 || at > 10) {
        EXPECT_EQ(image.pixels[at], static_cast<uint8_t>(kFour[at])) << at;
      }
    }
  }
}

TEST(ImageDecode, PngsOfEveryKindBecomeFourChannelsOfEightBits) {
  const std::string red("\xff\x00\x00\xff", 4), half("\x00\x00\xff\x80", 4), grey("\x55\x55\x55\xff", 4);
  // two pixels of two bits: entries 1 and 0
  EXPECT_EQ(
      pixelsOf(decoded(packedPng({2, 1, 2, PNG_COLOR_TYPE_PALETTE, 0, "\x40", std::string("\0\0\xff\xff\0\0", 6), "\x80"}))),
      red + half);
  EXPECT_EQ(pixelsOf(decoded(packedPng({1, 1, 2, PNG_COLOR_TYPE_GRAY, 0, "\x40", "", ""}))), grey);
  EXPECT_EQ(pixelsOf(decoded(packedPng({1, 1, 16, PNG_COLOR_TYPE_RGB, 0, std::string("\xff\xff\0\0\0\0", 6), "", ""}))), red);
  std::string rows;
  for (int i = 0; i < 81 * 3; ++i) rows += static_cast<char>(i);
  std::string all;
  for (int i = 0; i < 81; ++i) all += rows.substr(3 * static_cast<size_t>(i), 3) + '\xff';
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7})
    EXPECT_EQ(pixelsOf(decoded(packedPng({9, 9, 8, PNG_COLOR_TYPE_RGB, interlace, rows, "", ""}))), all) << interlace;
}

TEST(ImageDecode, JpegsOfOneScanAndOfManyAreTheSameColour) {
  for (const JpegKind kind : {JpegKind::plain, JpegKind::progressive}) {
    const DecodedImage image = decoded(jpeg(17, 10, 120, 230, kind));
    ASSERT_EQ(image.pixels.size(), 17u * 17u * 4u);
    constexpr std::array<int, 4> kExpected = {10, 120, 230, 255};
    for (size_t at = 0; at < image.pixels.size(); ++at) EXPECT_NEAR(image.pixels[at], kExpected[at % 4], 2) << at;
  }
}

// Two entries, the first of which is number 1: red and half green; of 2 x 2 pixels.
std::string mappedTarga(int kind, const std::string& pixels) {
  std::string bytes = targa(kind, 2, 2, 8, std::string("note\0\0\xff\xff\0\x80\0\x80", 12) + pixels);
  bytes[0] = 4;
  bytes[1] = bytes[3] = 1;
  bytes[5] = 2;
  bytes[7] = 32;
  return bytes;
}

TEST(ImageDecode, TargasOfEveryKind) {
  const std::string red("\xff\0\0\xff", 4), green("\0\x80\0\x80", 4), opaque_green("\0\xff\0\xff", 4);
  EXPECT_EQ(pixelsOf(decoded(mappedTarga(1, "\2\2\1\1"))), red + red + green + green) << "from the bottom";
  EXPECT_EQ(pixelsOf(decoded(mappedTarga(9, std::string("\x82\2\0\1", 4)))), green + red + green + green);
  // five bits a channel, red above; the highest is opacity where the header says so
  std::string of_16_bits = targa(2, 2, 1, 16, std::string("\x00\x7c\xe0\x83", 4));
  EXPECT_EQ(pixelsOf(decoded(of_16_bits)), red + opaque_green);
  of_16_bits[17] = 1;
  EXPECT_EQ(pixelsOf(decoded(of_16_bits)), red.substr(0, 3) + '\0' + opaque_green);
  EXPECT_EQ(pixelsOf(decoded(targa(10, 2, 1, 16, std::string("\x81\x00\x7c", 3)))), red + red);
  EXPECT_EQ(pixelsOf(decoded(targa(3, 1, 1, 16, "\x30\x40"))), "\x30\x30\x30\x40");
  EXPECT_EQ(pixelsOf(decoded(targa(11, 2, 1, 8, "\x81\x30"))), pixels(2, "\x30\x30\x30\xff"));
  EXPECT_EQ(pixelsOf(decoded(targa(10, 2, 1, 32, "\x81\x01\x02\x03\x04"))), pixels(2, "\x03\x02\x01\x04"));
  // two rows of one grey pixel each, from the bottom and from the top
  std::string upwards = targa(3, 1, 2, 8, "\x0a\x14"), downwards = upwards;
  downwards[17] = 0x20;
  EXPECT_EQ(decoded(upwards).pixels[0], 0x14);
  EXPECT_EQ(decoded(downwards).pixels[0], 0x0a);
}

// Adobe's programs store ink upside down, whether plain or as YCCK; others as it is.
TEST(ImageDecode, JpegsOfInkBecomeColours) {
  for (const InkJpeg& kind : {InkJpeg{false, false}, {true, false}, {true, true}}) {
    // cyan, magenta, yellow, black: a quarter, none, all, a fifth
    const DecodedImage image = decoded(inkJpeg(16, {64, 0, 255, 51}, kind));
    constexpr std::array<int, 4> kExpected = {153, 204, 0, 255};
    for (size_t at = 0; at < image.pixels.size(); ++at) EXPECT_NEAR(image.pixels[at], kExpected[at % 4], 3) << at;
  }
}

// --- what is kept

TEST(ReducedImage, KeepsAnImageOfOneColourExactly) {
  for (const auto& [width, height] : {std::pair{1, 1}, {512, 3}, {513, 700}, {1024, 1024}, {1000, 2}}) {
    const TextureImage image = reducedImage(decoded(png(width, height, pixels(width * height, "\x07\xbc\xfe\xff"))), {}, 512);
    EXPECT_EQ(image.width, std::min(width, 512));
    EXPECT_EQ(image.height, std::min(height, 512));
    ASSERT_EQ(image.texels.size(), static_cast<size_t>(image.width * image.height));
    for (const auto& texel : image.texels) ASSERT_EQ(texel, (std::array<uint8_t, 4>{0x07, 0xbc, 0xfe, 0xff}));
  }
}

TEST(ReducedImage, TakesMeansInLinearLight) {
  // three pixels to two texels: each of a whole one and half of the middle one
  const DecodedImage image = decoded(png(3, 1, std::string("\0\0\0\xff\xff\xff\xff\xff\0\0\0\xff", 12)));
  const TextureImage two = reducedImage(image, {}, 2);
  ASSERT_EQ(two.texels.size(), 2u);
  for (const auto& texel : two.texels) EXPECT_EQ(texel[0], srgbFromLinear(1.0 / 3.0));
  const TextureImage data = reducedImage(image, {KeptAs::Colour::data, KeptAs::Opacity::none, 0, {}}, 1);
  EXPECT_NEAR(linearFromSrgb(data.texels[0][0]), 1.0f / 3.0f, 0.003f) << "within half a code";
}

TEST(ReducedImage, CutsBeforeItTakesMeans) {
  // opacities of 100, 101, 102, 255: of a mean of 139
  std::string rgba;
  for (const char alpha : {'\x64', '\x65', '\x66', '\xff'}) rgba += std::string("\xff\xff\xff", 3) + alpha;
  const DecodedImage image = decoded(png(4, 1, rgba));
  const auto opacityOf = [&](KeptAs::Opacity opacity, int least) {
    return reducedImage(image, {KeptAs::Colour::srgb, opacity, least, {}}, 1).texels[0][3];
  };
  EXPECT_EQ(opacityOf(KeptAs::Opacity::none, 0), 255);
  EXPECT_EQ(opacityOf(KeptAs::Opacity::mean, 0), 140) << "139.5";
  EXPECT_EQ(opacityOf(KeptAs::Opacity::cut, 102), 128) << "half";
  EXPECT_EQ(opacityOf(KeptAs::Opacity::cut, 0), 255);
  EXPECT_EQ(opacityOf(KeptAs::Opacity::cut, 256), 0);
}

TEST(ReducedImage, ColoursCountByTheirOpacity) {
  // white that is there, and green that is not
  const DecodedImage image = decoded(png(2, 1, std::string("\xff\xff\xff\xff\0\xff\0\0", 8)));
  const TextureImage one = reducedImage(image, {KeptAs::Colour::srgb, KeptAs::Opacity::mean, 0, {}}, 1);
  EXPECT_EQ(one.texels[0], (std::array<uint8_t, 4>{255, 255, 255, 128}));
}

}  // namespace
}  // namespace nlg
