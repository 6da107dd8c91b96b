#include "scene/sky_file.h"

#include <IexBaseExc.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "scene/pk3_archive.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

// throws   InputError unless these are the sides of a whole sphere, of a size that is read
void requireSides(const std::string& path, int64_t width, int64_t height) {
  const std::string got = std::to_string(width) + " x " + std::to_string(height);
  if (width < 2 || height < 1 || width > kMaxSkyFileColumns)
    throw InputError(path, "size", "2 to " + std::to_string(kMaxSkyFileColumns) + " columns", got);
  if (width != 2 * height) throw InputError(path, "size", "an image twice as wide as high: all directions around", got);
}

// The bytes of a file, one after another.
class ByteStream {
 public:
  explicit ByteStream(const std::string& path) : path_(path), file_(path) {}

  uint8_t next() {
    if (at_ == filled_) fill();
    return buffer_[at_++];
  }
  void read(uint8_t* to, size_t count) {
    for (size_t i = 0; i < count; ++i) to[i] = next();
  }
  // Without its end; of at most so many characters.
  std::string line() {
    std::string text;
    for (char c = static_cast<char>(next()); c != '\n'; c = static_cast<char>(next())) {
      if (text.size() == 1024) throw InputError(path_, "header", "lines of at most 1024 characters", "more");
      text += c;
    }
    return text;
  }

 private:
  void fill() {
    filled_ = file_.read(buffer_.data(), buffer_.size());
    at_ = 0;
    if (filled_ == 0) throw InputError(path_, "pixels", "an image that is whole", "the file's end");
  }

  const std::string path_;
  InputFile file_;
  std::array<uint8_t, 1 << 16> buffer_{};
  size_t at_ = 0, filled_ = 0;
};

// Radiance's picture format: a header of lines, a line of sides, and rows of pixels with one exponent for three channels.
class HdrReader {
 public:
  explicit HdrReader(const std::string& path) : path_(path), bytes_(path) {}

  SkyFile read(double turn) {
    readHeader();
    SkyReduction reduction(width_, height_, turn);
    std::vector<float> rgb(3 * static_cast<size_t>(width_));
    for (int row = 0; row < height_; ++row) {
      readRow(row);
      for (int x = 0; x < width_; ++x) {
        const uint8_t* pixel = &pixels_[4 * static_cast<size_t>(x)];
        const float scale = pixel[3] == 0 ? 0.0f : std::ldexp(1.0f, pixel[3] - (128 + 8));
        for (int channel = 0; channel < 3; ++channel) rgb[3 * static_cast<size_t>(x) + channel] = pixel[channel] * scale;
      }
      reduction.addRow(row, rgb.data());
    }
    return {reduction.finish(), reduction.mended()};
  }

 private:
  void readHeader() {
    const std::string magic = bytes_.line();
    if (magic.rfind("#?", 0) != 0) throw InputError(path_, "header", "#?RADIANCE", "another beginning");
    bool is_rgbe = false;
    int lines = 0;
    for (std::string line = bytes_.line(); !line.empty(); line = bytes_.line()) {
      if (++lines > 1024) throw InputError(path_, "header", "an empty line behind at most 1024", "more");
      is_rgbe = is_rgbe || line == "FORMAT=32-bit_rle_rgbe";
    }
    if (!is_rgbe) throw InputError(path_, "header", "FORMAT=32-bit_rle_rgbe", "none such");
    const std::string sides = bytes_.line();
    int end = 0;
    if (std::sscanf(sides.c_str(), "-Y %6d +X %6d%n", &height_, &width_, &end) != 2 || sides.size() != static_cast<size_t>(end))
      throw InputError(path_, "header", "-Y HEIGHT +X WIDTH, rows from the top", "'" + sides.substr(0, 60) + "'");
    requireSides(path_, width_, height_);
    pixels_.resize(4 * static_cast<size_t>(width_));
  }

  [[noreturn]] void failRow(int row, const std::string& expected) const {
    throw InputError(path_, "row " + std::to_string(row), expected, "more");
  }

  void readRow(int row) {
    uint8_t* first = pixels_.data();
    bytes_.read(first, 4);
    const bool is_packed = first[0] == 2 && first[1] == 2 && first[2] < 128 && width_ >= 8 && width_ < 32768;
    if (!is_packed) return readPlain(row);
    if (first[2] * 256 + first[3] != width_)
      throw InputError(path_, "row " + std::to_string(row), std::to_string(width_) + " pixels",
                       std::to_string(first[2] * 256 + first[3]));
    for (size_t channel = 0; channel < 4; ++channel) {
      for (int x = 0; x < width_;) {
        const int code = bytes_.next();
        const bool is_run = code > 128;
        const int count = is_run ? code - 128 : code;
        if (count == 0 || count > width_ - x) failRow(row, "runs that end with the row");
        uint8_t value = 0;
        for (int i = 0; i < count; ++i, ++x) {
          if (!is_run || i == 0) value = bytes_.next();
          pixels_[4 * static_cast<size_t>(x) + channel] = value;
        }
      }
    }
  }

  // The first pixel has been read. One of 1 1 1 n repeats the one before it n times; several in a row say n's higher digits.
  void readPlain(int row) {
    int shift = 0;
    for (int x = 0; x < width_;) {
      uint8_t* pixel = &pixels_[4 * static_cast<size_t>(x)];
      if (x > 0) bytes_.read(pixel, 4);
      const bool is_run = x > 0 && pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1;
      if (!is_run) {
        ++x;
        shift = 0;
        continue;
      }
      const int64_t count = static_cast<int64_t>(pixel[3]) << shift;
      shift += 8;
      if (count > width_ - x || shift > 24) failRow(row, "runs that end with the row");
      for (int64_t i = 0; i < count; ++i, ++x)
        std::memcpy(&pixels_[4 * static_cast<size_t>(x)], &pixels_[4 * static_cast<size_t>(x - 1)], 4);
    }
  }

  const std::string path_;
  ByteStream bytes_;
  int width_ = 0, height_ = 0;
  std::vector<uint8_t> pixels_;  // of one row
};

// What OpenEXR reads from: regular files alone, as everywhere.
class ExrStream : public Imf::IStream {
 public:
  explicit ExrStream(const std::string& path) : IStream(path.c_str()), file_(path) {}
  bool read(char* to, int count) override {
    const size_t wanted = count < 0 ? 0 : static_cast<size_t>(count);
    if (file_.readAt(at_, to, wanted) != wanted) throw Iex::InputExc("the file ends too early");
    at_ += wanted;
    return at_ < file_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t at) override { at_ = at; }

 private:
  InputFile file_;
  uint64_t at_ = 0;
};

SkyFile readExr(const std::string& path, double turn) {
  constexpr int kRowsAtOnce = 32;
  Imf::Header::setMaxImageSize(kMaxSkyFileColumns, kMaxSkyFileColumns);
  Imf::Header::setMaxTileSize(4096, 4096);
  ExrStream stream(path);
  Imf::InputFile file(stream, 0);
  const Imath::Box2i window = file.header().dataWindow();
  const int64_t width = int64_t{window.max.x} - window.min.x + 1, height = int64_t{window.max.y} - window.min.y + 1;
  requireSides(path, width, height);
  const Imf::ChannelList& channels = file.header().channels();
  const bool is_grey = channels.findChannel("Y") != nullptr && channels.findChannel("R") == nullptr;
  const std::array<const char*, 3> names =
      is_grey ? std::array<const char*, 3>{"Y", "Y", "Y"} : std::array<const char*, 3>{"R", "G", "B"};
  for (const char* name : names) {
    const Imf::Channel* channel = channels.findChannel(name);
    if (channel == nullptr || channel->xSampling != 1 || channel->ySampling != 1)
      throw InputError(path, "channels", "R, G and B, or Y alone, one of each a pixel", std::string("no such ") + name);
  }
  if (is_grey && channels.findChannel("RY") != nullptr)
    throw InputError(path, "channels", "R, G and B, or Y alone", "Y with differences");
  SkyReduction reduction(static_cast<int>(width), static_cast<int>(height), turn);
  std::vector<float> rows(3 * static_cast<size_t>(width) * kRowsAtOnce);
  const size_t pixel_bytes = 3 * sizeof(float), row_bytes = pixel_bytes * static_cast<size_t>(width);
  for (int y = 0; y < height; y += kRowsAtOnce) {
    const int first = window.min.y + y, count = std::min<int>(kRowsAtOnce, static_cast<int>(height) - y);
    Imf::FrameBuffer buffer;
    // OpenEXR counts from the origin of the window's coordinates, wherever the window stands
    char* origin = reinterpret_cast<char*>(rows.data()) -
                   static_cast<std::ptrdiff_t>(window.min.x) * static_cast<std::ptrdiff_t>(pixel_bytes) -
                   static_cast<std::ptrdiff_t>(first) * static_cast<std::ptrdiff_t>(row_bytes);
    const int channel_count = is_grey ? 1 : 3;
    for (int channel = 0; channel < channel_count; ++channel)
      buffer.insert(names[channel], Imf::Slice(Imf::FLOAT, origin + channel * sizeof(float), pixel_bytes, row_bytes));
    file.setFrameBuffer(buffer);
    file.readPixels(first, first + count - 1);
    for (size_t pixel = 0; is_grey && pixel < static_cast<size_t>(width) * count; ++pixel)
      rows[3 * pixel + 1] = rows[3 * pixel + 2] = rows[3 * pixel];
    for (int row = 0; row < count; ++row) reduction.addRow(y + row, &rows[3 * static_cast<size_t>(width) * row]);
  }
  return {reduction.finish(), reduction.mended()};
}

}  // namespace

bool isSkyFile(const std::string& path) {
  const std::string extension = extensionOf(path);
  return extension == ".hdr" || extension == ".exr";
}

SkyFile readSkyFile(const std::string& path, double turn) {
  if (extensionOf(path) == ".hdr") return HdrReader(path).read(turn);
  try {
    return readExr(path, turn);
  } catch (const ToolError&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(path, "image", "OpenEXR", std::string(error.what()).substr(0, 200));
  }
}

}  // namespace nlg
