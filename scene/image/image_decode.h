// Decodes images: PNG, JPEG, WebP and Targa.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace nlg {

inline constexpr int kMostPixelsOfSide = 8192;

struct DecodedImage {
  int width = 0, height = 0;    // 1 … kMostPixelsOfSide each
  std::vector<uint8_t> pixels;  // width x height x 4, rows from the top: red, green, blue, alpha (255 where the file has none)
};

// What decoding takes of a scene's budget of pixels, from several threads at once. Images wait for each other where many large ones
// would take too much memory at once.
class PixelWork {
 public:
  explicit PixelWork(uint64_t most) : most_(most) {}

  // Counts them; false when they are more than there were.
  bool take(uint64_t pixels);
  // Waits until an image of so many pixels has room beside those that are being decoded.
  void enter(uint64_t pixels);
  void leave(uint64_t pixels);
  uint64_t taken();

 private:
  std::mutex mutex_;
  std::condition_variable has_left_;
  uint64_t most_, taken_ = 0, inside_ = 0;
};

// Pixels of whatever kind become 8 bits a channel; colour profiles, gamma and orientation that a file names are left aside, as glTF
// has it. Of a file with several pictures the first, if it stands for itself.
//
// bytes    the kind is known by the first ones; what begins like none of the others may be a Targa (of a palette, true colour or grey;
//          plain or run-length encoded). CMYK becomes red, green and blue without profiles
// work     the image's pixels are taken from it as soon as they are known, and for a JPEG once more with every scan behind the 16th
// image    what was decoded
// enough_side   a JPEG comes at a half, a quarter or an eighth of its size, means of its codes, where its shorter side stays as long
// returns  what is wrong with the image, to stand behind its name: "is damaged", "is KTX2, which is not read", "is larger than 8192
//          pixels a side"; empty when it was decoded. Damaged is one, too, for which work had too little
std::string decodeImage(std::string_view bytes, PixelWork& work, DecodedImage* image, int enough_side = kMostPixelsOfSide);

}  // namespace nlg
