#include "datagen/view/png_file.h"

#include <png.h>

#include <string_view>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {

void writePng(const std::string& path, const Image& image) {
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
  writeFileAtomically(path, std::string_view(bytes).substr(0, size));
}

}  // namespace nlg
