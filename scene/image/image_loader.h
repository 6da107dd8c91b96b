// Loads the images of a scene's materials: each is decoded once, and reduced as its materials need it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "scene/archive/scene_file.h"
#include "scene/image/image_decode.h"
#include "scene/model/texture_image.h"

namespace nlg {

// What is kept of an image.
struct KeptAs {
  enum class Colour { srgb, data, white };             // data: codes stand for numbers of 0 to 1 as they are
  enum class Opacity { none, mean, cut, brightness };  // brightness: the image's own opacity if it has one, else its red code
  Colour colour = Colour::srgb;
  Opacity opacity = Opacity::none;
  int least_code =
      0;  // of cut: pixels of this opacity (0 … 255) and above are whole, all others are not there; 256: none is whole
  std::string opacity_of;  // another image, whose opacity stands in the place of its own; empty: none

  auto operator<=>(const KeptAs&) const = default;
};

// Means over boxes of pixels, colours in linear light and, where there is an opacity, weighted by it: what a transmissive surface
// reflects is the product of the two. Cutting comes first: the mean is the covered share.
// most_side   at most kMostTexelsOfSide
TextureImage reducedImage(const DecodedImage& image, const KeptAs& kept, int most_side);

// The bytes of an image, somewhere in memory or its own.
struct ImageBytes {
  std::vector<unsigned char> own;
  std::span<const unsigned char> elsewhere;  // where it has none of its own
  std::string problem;                       // why there are none, to stand behind the image's name; empty where there are some
  std::string guess;                         // FileBeside's

  std::span<const unsigned char> bytes() const { return own.empty() ? elsewhere : std::span<const unsigned char>(own); }
};

inline constexpr float kUnreadGrey = 0.5f;  // linear: stands in the place of an image that could not be read

struct LoadedImages {
  std::vector<TextureImage> images;
  std::vector<int32_t> image_of;               // by the number that want() gave: which of them; -1: it could not be read
  std::map<std::string, std::string> unread;   // by name: what is wrong with it
  std::map<std::string, std::string> guessed;  // by address: the file that was read
  size_t left_out_count = 0;                   // of files that geometry does not need
  int most_side = kMostTexelsOfSide;           // that any was kept at; less where there are so many

  // Puts the image's index in the place of its number; false where there was one, and it could not be read.
  bool take(TextureUse* use) const;
};

// What images are read for: all that is to be seen, or what they say of geometry: opacity and transmission.
enum class ImageNeed : uint8_t { all, geometry };

class ImageLoader {
 public:
  explicit ImageLoader(ImageNeed need = ImageNeed::all) : need_(need) {}

  // The number of the image of that name, kept so; -1 for one that is not needed.
  int32_t want(const std::string& name, const KeptAs& kept);
  bool wantsNone() const { return wanted_.empty() && left_out_.empty(); }

  // Reads and decodes them, several at once.
  // open     gives an image's bytes by its name; called by one thread at a time
  // throws   InputError naming path on more pixels than the budget holds; whatever open throws
  LoadedImages load(const std::function<ImageBytes(const std::string& name)>& open, SceneBudget& pixels,
                    const std::string& path) const;

 private:
  ImageNeed need_;
  std::map<std::pair<std::string, KeptAs>, int32_t> wanted_;
  std::set<std::string> left_out_;
};

// What was not read and what stands in its place, one line for each thing that is wrong, and one where images are kept smaller than
// kMostTexelsOfSide for want of room.
std::vector<std::string> unreadImageNotes(const LoadedImages& loaded);

// The bytes of an image in the scene's folder or below, by its address (findBeside). What is not there, or elsewhere, is a problem; a file
// that cannot be read is an error.
ImageBytes imageBeside(const std::string& scene_path, const std::string& address, SceneBudget& bytes_left);

}  // namespace nlg
