#include "render/picture/image.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <png.h>
#include <zlib.h>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

uint8_t mixByte(uint8_t a, uint8_t b, double share) { return static_cast<uint8_t>(std::lround(a + share * (b - a))); }

// Decodes the UTF-8 sign at text[i] and moves i behind it; a broken one is the replacement character.
uint32_t nextCodePoint(const std::string& text, size_t* i) {
  const auto lead = static_cast<unsigned char>(text[(*i)++]);
  if (lead < 0x80) return lead;
  const int more = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : 1;
  uint32_t code_point = lead & (0x3f >> more);
  for (int k = 0; k < more; ++k, ++*i) {
    if (*i >= text.size() || (static_cast<unsigned char>(text[*i]) & 0xc0) != 0x80) return 0xfffd;
    code_point = code_point << 6 | (static_cast<unsigned char>(text[*i]) & 0x3f);
  }
  return code_point;
}

void addBigEndian(uint32_t value, std::string* bytes) {
  png_byte four[4];
  png_save_uint_32(four, value);
  bytes->append(reinterpret_cast<const char*>(four), sizeof(four));
}

// libpng's simple interface writes no texts: its file is taken apart behind the header, which is always the same length.
// PNG (third edition), 5.3 and 11.3.3.
std::string withTexts(std::string_view file, const PngTexts& texts) {
  constexpr size_t kHeaderEnd = 8 + 12 + 13;  // signature; length, name and checksum of a chunk; size and form of the picture
  std::string all(file.substr(0, kHeaderEnd));
  for (const auto& [keyword, text] : texts) {
    // not compressed, no language, no translated keyword
    const std::string content = std::string("iTXt") + keyword + std::string(5, '\0') + text;
    addBigEndian(static_cast<uint32_t>(content.size() - 4), &all);
    all += content;
    addBigEndian(
        static_cast<uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()))), &all);
  }
  return all.append(file.substr(kHeaderEnd));
}

}  // namespace

Colour mix(Colour a, Colour b, double share) {
  return {mixByte(a.r, b.r, share), mixByte(a.g, b.g, share), mixByte(a.b, b.b, share)};
}

Image::Image(int width, int height, Colour background) : width_(width), height_(height) {
  NLG_CHECK(width, >=, 1);
  NLG_CHECK(height, >=, 1);
  bytes_.resize(static_cast<size_t>(width) * height * 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) set(x, y, background);
  }
}

Colour Image::at(int x, int y) const {
  NLG_CHECK(contains(x, y), ==, true);
  const uint8_t* pixel = &bytes_[(static_cast<size_t>(y) * width_ + x) * 3];
  return {pixel[0], pixel[1], pixel[2]};
}

void Image::set(int x, int y, Colour colour) {
  if (!contains(x, y)) return;
  uint8_t* pixel = &bytes_[(static_cast<size_t>(y) * width_ + x) * 3];
  pixel[0] = colour.r, pixel[1] = colour.g, pixel[2] = colour.b;
}

void Image::blend(int x, int y, Colour colour, double share) {
  if (contains(x, y)) set(x, y, mix(at(x, y), colour, share));
}

void fillRect(Image& image, int x, int y, int width, int height, Colour colour) {
  for (int row = y; row < y + height; ++row) {
    for (int column = x; column < x + width; ++column) image.set(column, row, colour);
  }
}

Colour hatchColour(int x, int y) {
  constexpr Colour kGround{150, 150, 150}, kStripe{90, 90, 90};
  constexpr int kPeriod = 10, kStripeWidth = 3;
  return ((x + y) % kPeriod + kPeriod) % kPeriod < kStripeWidth ? kStripe : kGround;
}

void drawFrame(Image& image, int x, int y, int width, int height, Colour colour) {
  fillRect(image, x - 1, y - 1, width + 2, 1, colour);
  fillRect(image, x - 1, y + height, width + 2, 1, colour);
  fillRect(image, x - 1, y, 1, height, colour);
  fillRect(image, x + width, y, 1, height, colour);
}

void drawLine(Image& image, const glm::dvec2& a, const glm::dvec2& b, double width_px, Colour colour) {
  const glm::dvec2 step = b - a;
  const double squared = std::max(glm::dot(step, step), 1e-12), radius = 0.5 * width_px;
  const glm::dvec2 low = glm::min(a, b) - radius, high = glm::max(a, b) + radius;
  if (high.x < 0 || high.y < 0 || low.x > image.width() || low.y > image.height()) return;
  // clamped before they become integers: a line's end may lie anywhere
  const auto pixel = [](double at, int end) { return static_cast<int>(std::clamp(std::floor(at), 0.0, end - 1.0)); };
  const int x_end = pixel(high.x + 1, image.width()), y_end = pixel(high.y + 1, image.height());
  for (int y = pixel(low.y - 1, image.height()); y <= y_end; ++y) {
    for (int x = pixel(low.x - 1, image.width()); x <= x_end; ++x) {
      const glm::dvec2 from_a = glm::dvec2(x + 0.5, y + 0.5) - a;
      const double along = std::clamp(glm::dot(from_a, step) / squared, 0.0, 1.0);
      const double cover = 0.5 - (glm::length(from_a - along * step) - radius);
      if (cover > 0) image.blend(x, y, colour, std::min(cover, 1.0));
    }
  }
}

void drawText(Image& image, int x, int y, const std::string& text, Colour colour, int scale) {
  for (size_t i = 0; i < text.size(); x += kGlyphWidth * scale) {
    const auto rows = glyphRows(nextCodePoint(text, &i));
    for (int row = 0; row < kGlyphHeight; ++row) {
      for (int column = 0; column < kGlyphWidth; ++column) {
        if (rows[row] >> column & 1) fillRect(image, x + column * scale, y + row * scale, scale + (scale > 1), scale, colour);
      }
    }
  }
}

int textWidth(const std::string& text, int scale) {
  int count = 0;
  for (size_t i = 0; i < text.size(); ++count) nextCodePoint(text, &i);
  return count * kGlyphWidth * scale;
}

void paste(Image& image, const Image& inset, int x, int y) {
  for (int row = 0; row < inset.height(); ++row) {
    for (int column = 0; column < inset.width(); ++column) image.set(x + column, y + row, inset.at(column, row));
  }
}

void writePng(const std::string& path, const Image& image, const PngTexts& texts) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width());
  header.height = static_cast<png_uint_32>(image.height());
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  // sRGB as it is: no conversion to 8 bits, no padding of rows, no palette
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.bytes().data(), 0, nullptr) == 0) {
    throw OutputError(path, std::string("libpng: ") + header.message);
  }
  writeFileAtomically(path, withTexts(std::string_view(bytes).substr(0, size), texts));
}

}  // namespace nlg
