#include "scene/image/sky_file.h"

#include <IexBaseExc.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "scene/archive/pk3_archive.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

constexpr uint64_t kMaxExrRowBytes = uint64_t{1} << 20, kMaxExrHeaderBytes = uint64_t{1} << 24;

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
  uint64_t left() const { return file_.size() - passed_ - at_; }
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
    passed_ += filled_;
    filled_ = file_.read(buffer_.data(), buffer_.size());
    at_ = 0;
    if (filled_ == 0) throw InputError(path_, "pixels", "an image that is whole", "the file's end");
  }

  const std::string path_;
  InputFile file_;
  std::array<uint8_t, 1 << 16> buffer_{};
  size_t at_ = 0, filled_ = 0;
  uint64_t passed_ = 0;  // bytes before the buffer's
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

// The header of an OpenEXR file, safe to be read by its library: OpenEXR 3.1 takes as much memory as an attribute says that it has,
// however short the file is. What pixels need is held against its form here; all other attributes are made of a type that the library
// does not know, and then passes over.
class ExrHeader {
 public:
  // throws   InputError on another file, one of several parts or of deep pixels, and attributes that are not what they should be
  explicit ExrHeader(const std::string& path) : path_(path), stream_(path) {
    constexpr uint32_t kTiles = 0x200, kLongNames = 0x400;
    if (word() != 0x01312f76) fail("its beginning", "that of OpenEXR", "another");
    const uint32_t version = word();
    if ((version & ~(kTiles | kLongNames)) != 2)
      fail("version", "2, of one part with plain pixels", fmt::format("{:#x}", version));
    while (readAttribute()) {
    }
  }

  const std::string& bytes() const { return bytes_; }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected, const std::string& got) const {
    throw InputError(path_, "header: " + what, expected, got);
  }

  uint8_t next() {
    const uint8_t byte = stream_.next();
    bytes_ += static_cast<char>(byte);
    return byte;
  }
  uint32_t word() {
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value |= static_cast<uint32_t>(next()) << (8 * i);
    return value;
  }
  std::string name() {
    std::string text;
    for (char c = static_cast<char>(next()); c != '\0'; c = static_cast<char>(next())) {
      if (text.size() == 255) fail("names", "at most 255 characters", "more");
      text += c;
    }
    return text;
  }

  // False at the header's end.
  bool readAttribute() {
    struct Needed {
      const char *name, *type;
      uint32_t size;  // 0: any
    };
    constexpr Needed kNeeded[] = {{"channels", "chlist", 0},        {"compression", "compression", 1},
                                  {"dataWindow", "box2i", 16},      {"displayWindow", "box2i", 16},
                                  {"lineOrder", "lineOrder", 1},    {"pixelAspectRatio", "float", 4},
                                  {"screenWindowCenter", "v2f", 8}, {"screenWindowWidth", "float", 4},
                                  {"tiles", "tiledesc", 9},         {"type", "string", 0}};
    const std::string attribute = name();
    if (attribute.empty()) return false;
    const size_t type_at = bytes_.size();
    const std::string type = name();
    const uint32_t size = word();
    if (size > stream_.left() || bytes_.size() + size > kMaxExrHeaderBytes)
      fail("attribute " + attribute, "what the file and 16 MiB hold", std::to_string(size) + " bytes");
    const size_t value_at = bytes_.size();
    for (uint32_t i = 0; i < size; ++i) next();
    const auto* needed =
        std::find_if(std::begin(kNeeded), std::end(kNeeded), [&](const Needed& one) { return attribute == one.name; });
    if (needed == std::end(kNeeded)) {
      std::fill_n(bytes_.begin() + static_cast<std::ptrdiff_t>(type_at), type.size(), '?');
    } else if (type != needed->type || (needed->size != 0 && size != needed->size)) {
      fail("attribute " + attribute, needed->type, type + " of " + std::to_string(size) + " bytes");
    } else if (attribute == "channels") {
      checkChannels(std::string_view(bytes_).substr(value_at));
    }
    return true;
  }

  // Names, each ended by a 0 and followed by 16 bytes; an empty one at the end.
  void checkChannels(std::string_view list) const {
    while (!list.empty() && list[0] != '\0') {
      const size_t end = list.find('\0');
      if (end == std::string_view::npos || list.size() - end < 18) break;
      list.remove_prefix(end + 17);
    }
    if (list.size() != 1 || list[0] != '\0') fail("attribute channels", "a list that ends where it says", "another end");
  }

  const std::string path_;
  ByteStream stream_;
  std::string bytes_;
};

// What OpenEXR reads from: regular files alone, as everywhere, and its header as above.
class ExrStream : public Imf::IStream {
 public:
  explicit ExrStream(const std::string& path) : IStream(path.c_str()), header_(ExrHeader(path).bytes()), file_(path) {}
  bool read(char* to, int count) override {
    const size_t wanted = count < 0 ? 0 : static_cast<size_t>(count);
    if (at_ > file_.size() || wanted > file_.size() - at_ || file_.readAt(at_, to, wanted) != wanted)
      throw Iex::InputExc("the file ends too early");
    if (at_ < header_.size())
      std::copy_n(header_.begin() + static_cast<std::ptrdiff_t>(at_), std::min(wanted, header_.size() - at_), to);
    at_ += wanted;
    return at_ < file_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t at) override { at_ = at; }

 private:
  const std::string header_;
  InputFile file_;
  uint64_t at_ = 0;
};

// The channels that hold the image, once it is sure that they can be read and what a row of the file takes.
std::vector<const char*> exrChannels(const std::string& path, const Imf::Header& header, int64_t width) {
  const Imf::ChannelList& channels = header.channels();
  uint64_t row_bytes = 0;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel)
    row_bytes += sizeof(float) * static_cast<uint64_t>(width);
  // some compressions take 256 rows at once
  if (row_bytes > kMaxExrRowBytes)
    throw InputError(path, "channels", "rows of at most " + std::to_string(kMaxExrRowBytes) + " bytes",
                     std::to_string(row_bytes));
  const bool is_grey = channels.findChannel("Y") != nullptr && channels.findChannel("R") == nullptr;
  if (is_grey && channels.findChannel("RY") != nullptr)
    throw InputError(path, "channels", "R, G and B, or Y alone", "Y with differences");
  std::vector<const char*> names = is_grey ? std::vector<const char*>{"Y"} : std::vector<const char*>{"R", "G", "B"};
  for (const char* name : names) {
    const Imf::Channel* channel = channels.findChannel(name);
    if (channel == nullptr || channel->xSampling != 1 || channel->ySampling != 1)
      throw InputError(path, "channels", "R, G and B, or Y alone, one of each a pixel", std::string("no such ") + name);
  }
  return names;
}

SkyFile readExr(const std::string& path, double turn) {
  constexpr int kRowsAtOnce = 32;
  // what is larger OpenEXR refuses before it takes memory
  Imf::Header::setMaxImageSize(kMaxSkyFileColumns, kMaxSkyFileColumns);
  Imf::Header::setMaxTileSize(4096, 4096);
  ExrStream stream(path);
  // headers alone are read here, and no memory taken for pixels
  Imf::MultiPartInputFile file(stream, 0);
  const Imf::Header& header = file.header(0);
  if (header.hasType() && header.type() != Imf::SCANLINEIMAGE && header.type() != Imf::TILEDIMAGE)
    throw InputError(path, "type", "an image of scan lines or tiles", header.type().substr(0, 40));
  const Imath::Box2i window = header.dataWindow();
  const int64_t width = int64_t{window.max.x} - window.min.x + 1, height = int64_t{window.max.y} - window.min.y + 1;
  requireSides(path, width, height);
  const std::vector<const char*> names = exrChannels(path, header, width);
  const bool is_grey = names.size() == 1;
  Imf::InputPart part(file, 0);
  SkyReduction reduction(static_cast<int>(width), static_cast<int>(height), turn);
  std::vector<float> rows(3 * static_cast<size_t>(width) * kRowsAtOnce);
  const size_t pixel_bytes = 3 * sizeof(float), row_bytes = pixel_bytes * static_cast<size_t>(width);
  // a block of rows at a time: the image is never whole in memory
  for (int y = 0; y < height; y += kRowsAtOnce) {
    const int first = window.min.y + y, count = std::min<int>(kRowsAtOnce, static_cast<int>(height) - y);
    Imf::FrameBuffer buffer;
    // OpenEXR counts from the origin of the window's coordinates, wherever the window stands
    char* origin = reinterpret_cast<char*>(rows.data()) -
                   static_cast<std::ptrdiff_t>(window.min.x) * static_cast<std::ptrdiff_t>(pixel_bytes) -
                   static_cast<std::ptrdiff_t>(first) * static_cast<std::ptrdiff_t>(row_bytes);
    for (size_t channel = 0; channel < names.size(); ++channel)
      buffer.insert(names[channel], Imf::Slice(Imf::FLOAT, origin + channel * sizeof(float), pixel_bytes, row_bytes));
    part.setFrameBuffer(buffer);
    part.readPixels(first, first + count - 1);
    // a grey image has one channel, which stands for all three
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
