// Images of a few bytes, for tests that know their colours.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <jpeglib.h>
#include <png.h>
#include <webp/encode.h>

namespace nlg {

inline std::string targa(int kind, int width, int height, int bits, const std::string& pixels) {
  std::string header(18, '\0');
  header[2] = static_cast<char>(kind);
  header[12] = static_cast<char>(width);
  header[14] = static_cast<char>(height);
  header[16] = static_cast<char>(bits);
  return header + pixels;
}

// Of pixels of four bytes: red, green, blue, alpha.
inline std::string png(int width, int height, const std::string& rgba) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  png_image_write_to_memory(&image, nullptr, &size, 0, rgba.data(), 0, nullptr);
  std::string bytes(size, '\0');
  png_image_write_to_memory(&image, bytes.data(), &size, 0, rgba.data(), 0, nullptr);
  bytes.resize(size);
  return bytes;
}

inline std::string webp(int width, int height, const std::string& rgba) {
  uint8_t* out = nullptr;
  const size_t size = WebPEncodeLosslessRGBA(reinterpret_cast<const uint8_t*>(rgba.data()), width, height, 4 * width, &out);
  std::string bytes(reinterpret_cast<char*>(out), size);
  WebPFree(out);
  return bytes;
}

// An image's pixels, all alike.
inline std::string pixels(int count, const std::string& rgba) {
  std::string all;
  for (int i = 0; i < count; ++i) all += rgba;
  return all;
}

enum class JpegKind { plain, progressive };

// A square of pixels that are all alike, in the JPEG library's numbers for colours; `choose` sets what is not the default.
template <class Choose>
std::string jpegOf(int side, const std::vector<unsigned char>& pixel, J_COLOR_SPACE colours, const Choose& choose) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &out, &size);
  info.image_width = info.image_height = static_cast<unsigned>(side);
  info.input_components = static_cast<int>(pixel.size());
  info.in_color_space = colours;
  jpeg_set_defaults(&info);
  choose(info);
  jpeg_set_quality(&info, 100, TRUE);
  jpeg_start_compress(&info, TRUE);
  std::vector<unsigned char> row;
  for (int x = 0; x < side; ++x) row.insert(row.end(), pixel.begin(), pixel.end());
  unsigned char* row_start = row.data();
  for (int y = 0; y < side; ++y) jpeg_write_scanlines(&info, &row_start, 1);
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::string bytes(reinterpret_cast<char*>(out), size);
  free(out);
  return bytes;
}

// A square of one colour.
inline std::string jpeg(int side, unsigned char red, unsigned char green, unsigned char blue, JpegKind kind = JpegKind::plain) {
  return jpegOf(side, {red, green, blue}, JCS_RGB, [&](jpeg_compress_struct& info) {
    if (kind == JpegKind::progressive) jpeg_simple_progression(&info);
  });
}

struct InkJpeg {
  bool is_adobes, is_ycck;
};

// A square of cyan, magenta, yellow and black, 255 for all of each.
inline std::string inkJpeg(int side, std::vector<unsigned char> ink, const InkJpeg& kind) {
  for (unsigned char& channel : ink) channel = static_cast<unsigned char>(kind.is_adobes ? 255 - channel : channel);
  return jpegOf(side, ink, JCS_CMYK, [&](jpeg_compress_struct& info) {
    jpeg_set_colorspace(&info, kind.is_ycck ? JCS_YCCK : JCS_CMYK);
    info.write_Adobe_marker = kind.is_adobes ? TRUE : FALSE;
  });
}

}  // namespace nlg
