#include "scene/texture_colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <vector>

#include <jpeglib.h>

namespace nlg {
namespace {

constexpr uint32_t kMaxSide = 8192;

double linearOf(uint8_t code) {
  static const std::array<double, 256> kTable = [] {
    std::array<double, 256> table{};
    for (size_t i = 0; i < table.size(); ++i) {
      const double s = static_cast<double>(i) / 255.0;
      table[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    }
    return table;
  }();
  return kTable[code];
}

class ColourSum {
 public:
  void add(uint8_t red, uint8_t green, uint8_t blue) {
    linear_ += glm::dvec3(linearOf(red), linearOf(green), linearOf(blue));
    codes_ += glm::dvec3(red, green, blue);
    ++count_;
  }
  ImageMeans means() const {
    const auto count = static_cast<double>(count_);
    return {glm::vec3(linear_ / count), glm::vec3(codes_ / (255.0 * count))};
  }

 private:
  glm::dvec3 linear_{0.0}, codes_{0.0};
  uint64_t count_ = 0;
};

// libjpeg leaves by this; no object with a destructor may live in the function that sets the jump.
struct JpegErrors {
  jpeg_error_mgr base;
  std::jmp_buf leave;
};

void leaveJpeg(j_common_ptr info) { std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->leave, 1); }
void ignoreMessage(j_common_ptr) {}

// What decoding an image takes: pixels, times the scans so far.
struct JpegWork {
  jpeg_progress_mgr base{};
  uint64_t pixels_of_scan = 0, most = 0, taken = 0;
};

// libjpeg reads all scans of an image before it gives the first line: between two of their rows it asks here.
void countScans(j_common_ptr info) {
  JpegWork& work = *reinterpret_cast<JpegWork*>(info->progress);
  const auto scans = static_cast<uint64_t>(reinterpret_cast<j_decompress_ptr>(info)->input_scan_number);
  work.taken = std::max<uint64_t>(scans, 1) * work.pixels_of_scan;
  if (work.taken > work.most) leaveJpeg(info);
}

// Decodes to one pixel for 8 x 8; row is scratch of kMaxSide / 8 pixels. false on a damaged file, and on one that takes more work
// than it may
bool decodeJpeg(std::string_view bytes, JSAMPLE* row, JpegWork* work, ColourSum* sum) {
  JpegErrors errors;
  jpeg_decompress_struct info;
  info.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = leaveJpeg;
  errors.base.output_message = ignoreMessage;
  if (setjmp(errors.leave) != 0) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  info.mem->max_memory_to_use = 64L << 20;
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  bool is_good =
      info.image_width <= kMaxSide && info.image_height <= kMaxSide &&
      (info.jpeg_color_space == JCS_YCbCr || info.jpeg_color_space == JCS_GRAYSCALE || info.jpeg_color_space == JCS_RGB);
  // every scan of a progressive file is work over the whole image
  is_good = is_good && !info.progressive_mode;
  if (is_good) {
    work->pixels_of_scan = std::max(uint64_t{info.image_width} * info.image_height, kLeastScanPixels);
    work->base.progress_monitor = countScans;
    info.progress = &work->base;
    countScans(reinterpret_cast<j_common_ptr>(&info));
    info.out_color_space = JCS_RGB;
    info.dct_method = JDCT_ISLOW;
    info.scale_num = 1;
    info.scale_denom = 8;
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      jpeg_read_scanlines(&info, &row, 1);
      for (JDIMENSION x = 0; x < info.output_width; ++x) sum->add(row[3 * x], row[3 * x + 1], row[3 * x + 2]);
    }
    is_good = errors.base.num_warnings == 0;
  }
  jpeg_destroy_decompress(&info);
  return is_good;
}

class TargaReader {
 public:
  explicit TargaReader(std::string_view bytes) : bytes_(bytes) {}

  // take   is told of the pixels before they are decoded
  template <class Take>
  bool read(const Take& take, ColourSum* sum) {
    constexpr size_t kHeaderBytes = 18;
    if (bytes_.size() < kHeaderBytes) return false;
    const uint8_t kind = byte(2);
    const uint32_t width = byte(12) + 256u * byte(13);
    const uint32_t height = byte(14) + 256u * byte(15);
    const bool is_grey = kind == 3 || kind == 11;
    const bool is_packed = kind == 10 || kind == 11;
    pixel_bytes_ = byte(16) / 8u;
    if (!(kind == 2 || kind == 3 || is_packed) || byte(1) != 0 || byte(16) % 8 != 0) return false;
    if (is_grey ? pixel_bytes_ != 1 : pixel_bytes_ != 3 && pixel_bytes_ != 4) return false;
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) return false;
    at_ = kHeaderBytes + byte(0);
    const uint64_t count = uint64_t{width} * height;
    take(count);
    return is_packed ? readPacked(count, sum) : readPixels(count, sum);
  }

 private:
  uint8_t byte(size_t at) const { return static_cast<uint8_t>(bytes_[at]); }

  bool hasPixels(uint64_t count) const { return at_ <= bytes_.size() && count * pixel_bytes_ <= bytes_.size() - at_; }

  void addPixel(ColourSum* sum) const {
    if (pixel_bytes_ == 1) return sum->add(byte(at_), byte(at_), byte(at_));
    sum->add(byte(at_ + 2), byte(at_ + 1), byte(at_));
  }

  bool readPixels(uint64_t count, ColourSum* sum) {
    if (!hasPixels(count)) return false;
    for (uint64_t i = 0; i < count; ++i, at_ += pixel_bytes_) addPixel(sum);
    return true;
  }

  bool readPacked(uint64_t count, ColourSum* sum) {
    while (count > 0) {
      if (at_ >= bytes_.size()) return false;
      const uint8_t head = byte(at_++);
      const uint64_t run = std::min<uint64_t>((head & 0x7f) + 1u, count);
      count -= run;
      if (head < 0x80) {
        if (!readPixels(run, sum)) return false;
        continue;
      }
      if (!hasPixels(1)) return false;
      for (uint64_t i = 0; i < run; ++i) addPixel(sum);
      at_ += pixel_bytes_;
    }
    return true;
  }

  std::string_view bytes_;
  size_t at_ = 0;
  size_t pixel_bytes_ = 0;
};

}  // namespace

std::optional<ImageMeans> imageMeans(std::string_view bytes, SceneBudget& pixels, const std::string& path,
                                     const std::string& place) {
  const auto take = [&](uint64_t count) { pixels.take(count, path, place); };
  ColourSum sum;
  bool is_good = false;
  if (bytes.starts_with("\xff\xd8")) {
    std::vector<JSAMPLE> row(3 * (kMaxSide / 8 + 1));
    JpegWork work;
    work.most = pixels.left();
    is_good = decodeJpeg(bytes, row.data(), &work, &sum);
    take(work.taken);
  } else {
    is_good = TargaReader(bytes).read(take, &sum);
  }
  if (!is_good) return std::nullopt;
  return sum.means();
}

}  // namespace nlg
