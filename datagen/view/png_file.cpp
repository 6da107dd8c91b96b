#include "datagen/view/png_file.h"

#include <png.h>
#include <zlib.h>

#include <string_view>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

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
