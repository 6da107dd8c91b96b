#include "scene/image/image_decode.h"

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <jpeglib.h>
// after the library's own
#include <jerror.h>
#include <png.h>
#include <webp/decode.h>

#include "scene/archive/scene_file.h"

namespace nlg {
namespace {

// Decoded at once; one image may be larger.
constexpr uint64_t kPixelsAtOnce = uint64_t{1} << 25;
constexpr size_t kChannels = 4;
constexpr int kScansOfAnyImage = 16;  // programs write ten; more count each

const char* const kDamaged = "is damaged";
const char* const kTooLarge = "is larger than 8192 pixels a side";
const char* const kOtherJpeg = "is a JPEG of a kind that is not read (12 bits, lossless, arithmetic or of other channels)";

using Pixels = std::vector<uint8_t>;

// The image in the making: what every decoder does once it knows the size.
class Canvas {
 public:
  Canvas(PixelWork& work, DecodedImage* image) : work_(work), image_(image) {}
  ~Canvas() {
    if (inside_ > 0) work_.leave(inside_);
  }
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  // least     pixels, as which a smaller image counts
  // returns   false where nothing may be decoded, for the reason that problem() says
  bool open(uint64_t width, uint64_t height, uint64_t least = 1) {
    if (width < 1 || height < 1) return refuse(kDamaged);
    if (width > kMostPixelsOfSide || height > kMostPixelsOfSide) return refuse(kTooLarge);
    pixels_of_scan_ = std::max(width * height, least);
    if (!work_.take(pixels_of_scan_)) return refuse(kDamaged);
    work_.enter(width * height);
    inside_ = width * height;
    image_->width = static_cast<int>(width);
    image_->height = static_cast<int>(height);
    image_->pixels.resize(width * height * kChannels);
    return true;
  }
  // Another pass over all pixels.
  bool scanAgain() { return work_.take(pixels_of_scan_); }

  uint8_t* row(size_t y) { return image_->pixels.data() + y * static_cast<size_t>(image_->width) * kChannels; }
  size_t byteCount() const { return image_->pixels.size(); }
  int width() const { return image_->width; }
  int height() const { return image_->height; }
  bool refuse(const char* problem) {
    problem_ = problem;
    return false;
  }
  const char* problem() const { return problem_; }

 private:
  PixelWork& work_;
  DecodedImage* image_;
  uint64_t pixels_of_scan_ = 0, inside_ = 0;
  const char* problem_ = kDamaged;
};

// --- JPEG and PNG: their libraries leave by a jump, so that no object with a destructor may live in the functions that set it.

struct JpegErrors {
  jpeg_error_mgr base;
  std::jmp_buf leave;
  int damage_count;
};

void leaveJpeg(j_common_ptr info) { std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->leave, 1); }

// Warnings are of pixels that are missing or made up, but for bytes between two markers, which many cameras leave.
void countDamage(j_common_ptr info, int level) {
  JpegErrors& errors = *reinterpret_cast<JpegErrors*>(info->err);
  if (level < 0 && errors.base.msg_code != JWRN_EXTRANEOUS_DATA) ++errors.damage_count;
}

struct JpegProgress {
  jpeg_progress_mgr base;
  Canvas* canvas;
  int scan_count;
};

// libjpeg reads all scans of an image before it gives the first line: between two of their rows it asks here.
void countScans(j_common_ptr info) {
  JpegProgress& progress = *reinterpret_cast<JpegProgress*>(info->progress);
  for (; progress.scan_count < reinterpret_cast<j_decompress_ptr>(info)->input_scan_number; ++progress.scan_count) {
    if (progress.scan_count >= kScansOfAnyImage && !progress.canvas->scanAgain()) leaveJpeg(info);
  }
}

// Programs of Adobe's store what is not printed.
void readCmyk(const JSAMPLE* ink, bool is_inverted, uint8_t* pixel) {
  const auto bare = [&](int channel) { return is_inverted ? ink[channel] : 255 - ink[channel]; };
  for (int channel = 0; channel < 3; ++channel) pixel[channel] = static_cast<uint8_t>((bare(channel) * bare(3) + 127) / 255);
}

// row   room for a row of four channels
bool decodeJpeg(std::string_view bytes, int enough_side, JSAMPLE* row, Canvas* canvas) {
  JpegErrors errors;
  jpeg_decompress_struct info;
  JpegProgress progress;
  // libjpeg leaves by longjmp, which runs no destructor: nothing here may own memory
  info.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = leaveJpeg;
  errors.base.emit_message = countDamage;
  errors.damage_count = 0;
  if (setjmp(errors.leave) != 0) {
    const int code = errors.base.msg_code;
    jpeg_destroy_decompress(&info);
    const bool is_other = code == JERR_BAD_PRECISION || code == JERR_SOF_UNSUPPORTED || code == JERR_ARITH_NOTIMPL;
    return is_other && canvas->refuse(kOtherJpeg);
  }
  jpeg_create_decompress(&info);
  info.mem->max_memory_to_use = 512L << 20;  // a progressive image of the largest size
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  // libjpeg does not convert ink to RGB: CMYK and YCCK are read as ink
  const bool is_cmyk = info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK;
  bool is_good = is_cmyk || info.jpeg_color_space == JCS_YCbCr || info.jpeg_color_space == JCS_GRAYSCALE ||
                 info.jpeg_color_space == JCS_RGB || canvas->refuse(kOtherJpeg);
  info.out_color_space = is_cmyk ? JCS_CMYK : JCS_RGB;
  // scaled within the DCT by 2, 4 or 8, while the shorter side keeps enough texels: reads large files fast
  const bool is_large = info.image_width > kMostPixelsOfSide || info.image_height > kMostPixelsOfSide;
  while (!is_large && info.scale_denom < 8 &&
         std::min(info.image_width, info.image_height) / (2 * info.scale_denom) >= static_cast<unsigned>(enough_side))
    info.scale_denom *= 2;
  if (is_good) jpeg_calc_output_dimensions(&info);
  is_good = is_good && canvas->open(info.output_width, info.output_height, kLeastScanPixels);
  if (is_good) {
    // counts the scans of progressive files: each costs a pass over all coefficients
    std::memset(&progress.base, 0, sizeof progress.base);
    progress.base.progress_monitor = countScans;
    progress.canvas = canvas;
    progress.scan_count = 0;
    info.progress = &progress.base;
    info.dct_method = JDCT_ISLOW;
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      uint8_t* pixel = canvas->row(info.output_scanline);
      jpeg_read_scanlines(&info, &row, 1);
      for (JDIMENSION x = 0; x < info.output_width; ++x, pixel += kChannels) {
        if (is_cmyk)
          readCmyk(row + 4 * x, info.saw_Adobe_marker != 0, pixel);
        else
          std::memcpy(pixel, row + 3 * x, 3);
        pixel[3] = 255;
      }
    }
    is_good = errors.damage_count == 0;
  }
  jpeg_destroy_decompress(&info);
  return is_good;
}

void leavePng(png_structp png, png_const_charp) { std::longjmp(*static_cast<std::jmp_buf*>(png_get_error_ptr(png)), 1); }
void ignoreWarning(png_structp, png_const_charp) {}

void readPngBytes(png_structp png, png_bytep to, size_t count) {
  std::string_view& left = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (count > left.size()) png_error(png, "cut");
  std::memcpy(to, left.data(), count);
  left.remove_prefix(count);
}

bool decodePng(std::string_view* bytes, Canvas* canvas) {
  std::jmp_buf leave;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &leave, leavePng, ignoreWarning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) {
    png_destroy_read_struct(&png, nullptr, nullptr);
    return false;
  }
  // libpng leaves by longjmp, too
  if (setjmp(leave) != 0) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_read_fn(png, bytes, readPngBytes);
  png_set_chunk_malloc_max(png, size_t{8} << 20);
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);  // texts, profiles: inflated for nothing
  png_set_user_limits(png, 0x7fffffff, 0x7fffffff);                       // the canvas says which is too large
  png_read_info(png, info);
  bool is_good = canvas->open(png_get_image_width(png, info), png_get_image_height(png, info));
  if (is_good) {
    // all kinds of PNG become 8 bits of red, green, blue and alpha
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
    // interlaced images fill the same rows in several passes
    const int pass_count = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    is_good = png_get_rowbytes(png, info) * static_cast<size_t>(canvas->height()) == canvas->byteCount();
    for (int pass = 0; is_good && pass < pass_count; ++pass) {
      for (int y = 0; y < canvas->height(); ++y) png_read_row(png, canvas->row(static_cast<size_t>(y)), nullptr);
    }
  }
  png_destroy_read_struct(&png, &info, nullptr);
  return is_good;
}

// --- the others

bool decodeWebp(std::string_view bytes, Canvas* canvas) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK) return false;
  if (features.has_animation != 0) return canvas->refuse("is an animated WebP, which is not read");
  if (!canvas->open(static_cast<uint64_t>(features.width), static_cast<uint64_t>(features.height))) return false;
  const int stride = canvas->width() * static_cast<int>(kChannels);
  return WebPDecodeRGBAInto(data, bytes.size(), canvas->row(0), canvas->byteCount(), stride) != nullptr;
}

class TargaDecoder {
 public:
  TargaDecoder(std::string_view bytes, Canvas* canvas) : bytes_(bytes), canvas_(canvas) {}

  bool decode() {
    constexpr size_t kHeaderBytes = 18;
    const bool is_targa = bytes_.size() >= kHeaderBytes && (byte(2) & ~8) >= 1 && (byte(2) & ~8) <= 3 && byte(1) <= 1;
    if (!is_targa) return canvas_->refuse("is of no kind that is read");
    const int kind = byte(2) & ~8;  // 1 of a palette, 2 of colours, 3 grey
    const bool is_packed = (byte(2) & 8) != 0;
    pixel_bytes_ = (byte(16) + 7u) / 8;
    const size_t entry_bytes = (byte(7) + 7u) / 8, entry_count = byte(1) == 0 ? 0 : wordAt(5);
    at_ = kHeaderBytes + byte(0);
    if (kind == 1) palette_ = {at_, wordAt(3), entry_count};
    colour_bytes_ = kind == 1 ? entry_bytes : pixel_bytes_;
    is_grey_ = kind == 3;
    const bool is_good = colour_bytes_ >= (is_grey_ ? 1 : 2) && colour_bytes_ <= (is_grey_ ? 2 : 4) &&
                         (kind != 1 || (entry_count > 0 && pixel_bytes_ >= 1 && pixel_bytes_ <= 2));
    if (!is_good) return false;
    has_bit_of_alpha_ = (byte(17) & 0x0f) == 1;
    const uint64_t width = wordAt(12), height = wordAt(14);
    if (!hasBytes(entry_count * entry_bytes)) return false;
    at_ += entry_count * entry_bytes;
    if (!is_packed && !hasPixels(width * height)) return false;
    if (!canvas_->open(width, height)) return false;
    is_downwards_ = (byte(17) & 0x20) != 0;
    is_leftwards_ = (byte(17) & 0x10) != 0;
    return (is_packed ? readPacked(width * height) : readPixels(width * height)) && has_entries_;
  }

 private:
  // Where its entries lie, the number of the first one, and how many there are.
  struct Palette {
    size_t at = 0, first = 0, count = 0;
  };

  uint8_t byte(size_t at) const { return static_cast<uint8_t>(bytes_[at]); }
  uint32_t wordAt(size_t at) const { return byte(at) + 256u * byte(at + 1); }

  bool hasBytes(uint64_t count) const { return at_ <= bytes_.size() && count <= bytes_.size() - at_; }
  bool hasPixels(uint64_t count) const { return hasBytes(count * pixel_bytes_); }

  void readColour(size_t at, uint8_t* pixel) const {
    if (is_grey_) {
      std::fill_n(pixel, 3, byte(at));
      pixel[3] = colour_bytes_ == 2 ? byte(at + 1) : 255;
    } else if (colour_bytes_ == 2) {
      const uint32_t word = wordAt(at);
      for (int channel = 0; channel < 3; ++channel)
        pixel[channel] = static_cast<uint8_t>((word >> (10 - 5 * channel) & 31) * 255 / 31);
      pixel[3] = has_bit_of_alpha_ && (word & 0x8000) == 0 ? 0 : 255;
    } else {
      for (size_t channel = 0; channel < 3; ++channel) pixel[channel] = byte(at + 2 - channel);
      pixel[3] = colour_bytes_ == 4 ? byte(at + 3) : 255;
    }
  }

  void addPixel() {
    const auto width = static_cast<size_t>(canvas_->width());
    const size_t x = written_ % width, y = written_ / width;
    uint8_t* pixel = canvas_->row(is_downwards_ ? y : static_cast<size_t>(canvas_->height()) - 1 - y);
    pixel += kChannels * (is_leftwards_ ? width - 1 - x : x);
    ++written_;
    if (palette_.count == 0) return readColour(at_, pixel);
    const size_t entry = (pixel_bytes_ == 1 ? byte(at_) : wordAt(at_)) - palette_.first;
    has_entries_ = has_entries_ && entry < palette_.count;
    if (has_entries_) readColour(palette_.at + entry * colour_bytes_, pixel);
  }

  bool readPixels(uint64_t count) {
    if (!hasPixels(count)) return false;
    for (uint64_t i = 0; i < count; ++i, at_ += pixel_bytes_) addPixel();
    return true;
  }

  bool readPacked(uint64_t count) {
    while (count > 0) {
      if (at_ >= bytes_.size()) return false;
      const uint8_t head = byte(at_++);
      const uint64_t run = std::min<uint64_t>((head & 0x7f) + 1u, count);
      count -= run;
      if (head < 0x80) {
        if (!readPixels(run)) return false;
        continue;
      }
      if (!hasPixels(1)) return false;
      for (uint64_t i = 0; i < run; ++i) addPixel();
      at_ += pixel_bytes_;
    }
    return true;
  }

  std::string_view bytes_;
  Canvas* canvas_;
  size_t at_ = 0, pixel_bytes_ = 0, colour_bytes_ = 0, written_ = 0;
  Palette palette_;  // of no entries: pixels are colours
  bool is_downwards_ = false, is_leftwards_ = false, is_grey_ = false, has_bit_of_alpha_ = false;
  bool has_entries_ = true;  // that pixels name
};

// Kinds that are known, and not read.
struct OtherKind {
  std::string_view start;
  const char* problem;
};
constexpr OtherKind kOtherKinds[] = {{"\xabKTX 20", "is KTX2, which is not read"},
                                     {"\xabKTX 11", "is KTX, which is not read"},
                                     {"DDS ", "is DDS, which is not read"},
                                     {"GIF8", "is GIF, which is not read"},
                                     {"BM", "is BMP, which is not read"},
                                     {"II*", "is TIFF, which is not read"},
                                     {"MM\0*", "is TIFF, which is not read"},
                                     {"8BPS", "is PSD, which is not read"},
                                     {"\xff\x0a", "is JPEG XL, which is not read"},
                                     {"#?RADIANCE", "is Radiance HDR, which is not read"},
                                     {"\x76\x2f\x31\x01", "is OpenEXR, which is not read"}};

bool decodeInto(std::string_view bytes, int enough_side, Canvas& canvas) {
  if (bytes.starts_with("\xff\xd8")) {
    std::vector<JSAMPLE> row(4 * kMostPixelsOfSide);
    return decodeJpeg(bytes, enough_side, row.data(), &canvas);
  }
  if (bytes.starts_with("\x89PNG")) return decodePng(&bytes, &canvas);
  if (bytes.size() >= 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP") return decodeWebp(bytes, &canvas);
  if (bytes.size() >= 12 && bytes.substr(4, 4) == "ftyp") return canvas.refuse("is AVIF or HEIF, which is not read");
  for (const OtherKind& kind : kOtherKinds) {
    if (bytes.starts_with(kind.start)) return canvas.refuse(kind.problem);
  }
  return TargaDecoder(bytes, &canvas).decode();
}

}  // namespace

bool PixelWork::take(uint64_t pixels) {
  const std::lock_guard lock(mutex_);
  taken_ += pixels;
  return taken_ <= most_;
}

uint64_t PixelWork::taken() {
  const std::lock_guard lock(mutex_);
  return taken_;
}

void PixelWork::enter(uint64_t pixels) {
  std::unique_lock lock(mutex_);
  has_left_.wait(lock, [&] { return inside_ == 0 || inside_ + pixels <= kPixelsAtOnce; });
  inside_ += pixels;
}

void PixelWork::leave(uint64_t pixels) {
  {
    const std::lock_guard lock(mutex_);
    inside_ -= pixels;
  }
  has_left_.notify_all();
}

std::string decodeImage(std::string_view bytes, PixelWork& work, DecodedImage* image, int enough_side) {
  Canvas canvas(work, image);
  if (decodeInto(bytes, enough_side, canvas)) return {};
  *image = {};
  return canvas.problem();
}

}  // namespace nlg
