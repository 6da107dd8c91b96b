#include "scene/image/image_loader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "scene/archive/scene_file.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr int kMostThreads = 8;
constexpr int kEnough = 4;  // pixels for a texel: means of so few codes are near those of light

// Which of fewer texels a pixel of a row belongs to: one, or two that share it. A texel is as wide as side pixels and a pixel as
// texel_count, so that shares are whole numbers.
struct Boxes {
  struct Part {
    size_t texel;
    float share, share_of_next;
  };
  std::vector<Part> of_pixel;
  int texel_count;

  Boxes(int side, int most_side) : texel_count(std::min(side, most_side)) {
    for (int64_t at = 0; at < int64_t{side} * texel_count; at += texel_count) {
      const int64_t texel = at / side, end = std::min<int64_t>(at + texel_count, (texel + 1) * side);
      of_pixel.push_back({static_cast<size_t>(texel), static_cast<float>(end - at), static_cast<float>(at + texel_count - end)});
    }
  }
};

// Sums over pixels, one for each texel of a row.
struct Sums {
  std::vector<glm::vec4> whole;    // red, green, blue, and how much of all pixels
  std::vector<glm::vec4> covered;  // the same, weighted by opacity

  explicit Sums(size_t count) : whole(count, glm::vec4(0.0f)), covered(count, glm::vec4(0.0f)) {}
  void clear() { *this = Sums(whole.size()); }
  void add(const Sums& other, float share) {
    for (size_t x = 0; x < whole.size(); ++x) {
      whole[x] += share * other.whole[x];
      covered[x] += share * other.covered[x];
    }
  }
};

class Reducer {
 public:
  Reducer(const DecodedImage& image, const KeptAs& kept) : image_(image), kept_(kept) {
    for (size_t code = 0; code < 256; ++code) {
      const float share = static_cast<float>(code) / 255.0f;
      colours_[code] = kept.colour == KeptAs::Colour::white  ? 1.0f
                       : kept.colour == KeptAs::Colour::data ? share
                                                             : linearFromSrgb(static_cast<uint8_t>(code));
      opacities_[code] = kept.opacity != KeptAs::Opacity::cut ? share : static_cast<int>(code) >= kept.least_code ? 1.0f : 0.0f;
    }
    if (kept.opacity != KeptAs::Opacity::brightness) return;
    bool has_opacity = false;
    for (size_t at = 3; at < image.pixels.size(); at += 4) has_opacity = has_opacity || image.pixels[at] != 255;
    opacity_channel_ = has_opacity ? 3 : 0;
  }

  TextureImage reduce(int most_side) const {
    const Boxes across(image_.width, most_side), down(image_.height, most_side);
    TextureImage result{across.texel_count, down.texel_count, {}};
    const auto width = static_cast<size_t>(result.width);
    result.texels.reserve(width * static_cast<size_t>(result.height));
    Sums row(width), texels(width);
    for (size_t y = 0; y < down.of_pixel.size(); ++y) {
      row.clear();
      sumRow(y, across, &row);
      const Boxes::Part& part = down.of_pixel[y];
      if (part.texel * width > result.texels.size()) finishRow(&texels, &result);
      texels.add(row, part.share);
      if (part.share_of_next == 0.0f) continue;
      finishRow(&texels, &result);
      texels.add(row, part.share_of_next);
    }
    finishRow(&texels, &result);
    return result;
  }

 private:
  void sumRow(size_t y, const Boxes& across, Sums* row) const {
    const uint8_t* codes = image_.pixels.data() + y * across.of_pixel.size() * 4;
    const bool has_opacity = kept_.opacity != KeptAs::Opacity::none;
    for (const Boxes::Part& part : across.of_pixel) {
      const glm::vec4 pixel(colours_[codes[0]], colours_[codes[1]], colours_[codes[2]], 1.0f);
      addPixel(pixel, part, &row->whole);
      if (has_opacity) addPixel(opacities_[codes[opacity_channel_]] * pixel, part, &row->covered);
      codes += 4;
    }
  }

  static void addPixel(const glm::vec4& pixel, const Boxes::Part& part, std::vector<glm::vec4>* sums) {
    (*sums)[part.texel] += part.share * pixel;
    if (part.share_of_next != 0.0f) (*sums)[part.texel + 1] += part.share_of_next * pixel;
  }

  void finishRow(Sums* texels, TextureImage* result) const {
    for (size_t x = 0; x < texels->whole.size(); ++x) {
      const glm::vec4 &whole = texels->whole[x], &covered = texels->covered[x];
      const bool has_opacity = kept_.opacity != KeptAs::Opacity::none;
      // where nothing is there, the colour is for the rims of the neighbours
      const glm::vec4 colour = covered.a > 0.0f ? covered / covered.a : whole / whole.a;
      const float opacity = has_opacity ? covered.a / whole.a : 1.0f;
      result->texels.push_back({srgbFromLinear(colour.r), srgbFromLinear(colour.g), srgbFromLinear(colour.b),
                                static_cast<uint8_t>(std::lround(255.0f * opacity))});
    }
    texels->clear();
  }

  const DecodedImage& image_;
  const KeptAs& kept_;
  std::array<float, 256> colours_, opacities_;
  size_t opacity_channel_ = 3;
};

// An image with another one's opacity, texel by texel of its own.
void takeOpacity(const TextureImage& from, TextureImage* image) {
  const TextureUse use;
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const glm::vec2 place((static_cast<float>(x) + 0.5f) / static_cast<float>(image->width),
                            (static_cast<float>(y) + 0.5f) / static_cast<float>(image->height));
      const float opacity = texelAt(from, use, place).a;
      image->texels[static_cast<size_t>(y) * image->width + x][3] = static_cast<uint8_t>(std::lround(255.0f * opacity));
    }
  }
}

}  // namespace

TextureImage reducedImage(const DecodedImage& image, const KeptAs& kept, int most_side) {
  return Reducer(image, kept).reduce(most_side);
}

bool LoadedImages::take(TextureUse* use) const {
  if (!use->isThere()) return true;
  use->image = image_of[static_cast<size_t>(use->image)];
  return use->isThere();
}

int32_t ImageLoader::want(const std::string& name, const KeptAs& kept) {
  if (need_ == ImageNeed::geometry && kept.opacity == KeptAs::Opacity::none && kept.opacity_of.empty() &&
      kept.colour != KeptAs::Colour::data) {
    left_out_.insert(name);
    return -1;
  }
  return wanted_.try_emplace({name, kept}, static_cast<int32_t>(wanted_.size())).first->second;
}

LoadedImages ImageLoader::load(const std::function<ImageBytes(const std::string& name)>& open, SceneBudget& pixels,
                               const std::string& path) const {
  // by image: the ways it is kept in, each beside its number
  std::vector<std::pair<std::string, std::vector<std::pair<KeptAs, int32_t>>>> jobs;
  for (const auto& [wanted, number] : wanted_) {
    if (jobs.empty() || jobs.back().first != wanted.first) jobs.push_back({wanted.first, {}});
    jobs.back().second.emplace_back(wanted.second, number);
  }
  LoadedImages loaded;
  loaded.left_out_count = left_out_.size();
  // all images give up resolution together: none is left out for its place in the file
  while (wanted_.size() * size_t(loaded.most_side) * loaded.most_side > kMaxTexels && loaded.most_side > 1) loaded.most_side /= 2;

  std::vector<TextureImage> kept(wanted_.size());
  std::mutex mutex;  // of open, of unread and of what follows
  std::string one_too_many;
  PixelWork work(pixels.left());
  const auto decode = [&](const std::string& name, DecodedImage* image) {
    ImageBytes file;
    {
      const std::lock_guard lock(mutex);
      file = open(name);
      if (!file.guess.empty()) loaded.guessed[name] = file.guess;
    }
    if (file.problem.empty()) {
      const std::span<const unsigned char> bytes = file.bytes();
      file.problem =
          decodeImage({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, work, image, kEnough * loaded.most_side);
    }
    if (file.problem.empty()) return true;
    const std::lock_guard lock(mutex);
    loaded.unread[name] = file.problem;
    if (one_too_many.empty() && work.taken() > pixels.left()) one_too_many = name;
    return false;
  };
  const auto keep = [&](uint64_t job, int) {
    DecodedImage image;
    if (!decode(jobs[job].first, &image)) return;
    // one decoding serves all the ways in which an image is kept
    for (const auto& [way, number] : jobs[job].second) {
      TextureImage& result = kept[static_cast<size_t>(number)];
      result = reducedImage(image, way, loaded.most_side);
      DecodedImage other;
      if (way.opacity_of.empty() || !decode(way.opacity_of, &other)) continue;
      takeOpacity(reducedImage(other, {KeptAs::Colour::white, KeptAs::Opacity::brightness, 0, {}}, loaded.most_side), &result);
    }
  };
  // each thread holds a decoded image: memory bounds their number, too
  const int thread_count = std::clamp(static_cast<int>(std::min<size_t>(jobs.size(), kMostThreads)), 1, machineThreadCount());
  parallelFor(jobs.size(), thread_count, keep);
  // decoded pixels count against the scene's budget; the error names the image that exceeded it
  pixels.take(work.taken(), path, one_too_many);

  // an image that could not be read has number -1: grey in its place, or dark where it would shine
  for (TextureImage& image : kept) {
    loaded.image_of.push_back(image.texels.empty() ? -1 : static_cast<int32_t>(loaded.images.size()));
    if (!image.texels.empty()) loaded.images.push_back(std::move(image));
  }
  return loaded;
}

std::vector<std::string> unreadImageNotes(const LoadedImages& loaded) {
  constexpr size_t kMostNames = 3;
  std::map<std::string, std::vector<std::string>> by_problem;
  std::string others;
  for (const auto& [name, problem] : loaded.unread) by_problem[problem].push_back(name.substr(0, 80));
  std::vector<std::string> notes;
  // one note a problem, with three names: a folder that was moved breaks all images at once
  for (const auto& [problem, names] : by_problem) {
    std::string some;
    for (size_t i = 0; i < std::min(names.size(), kMostNames); ++i) some += (i > 0 ? ", \"" : "\"") + names[i] + "\"";
    if (names.size() > kMostNames) some += fmt::format(" and {} more", names.size() - kMostNames);
    notes.push_back(fmt::format("{} not read: {}, {} {}: grey in its place, or dark where it would shine",
                                counted(names.size(), "image is", "images are"), some,
                                names.size() == 1 ? "which" : "each of which", problem));
  }
  if (loaded.left_out_count > 0)
    notes.push_back(fmt::format("{} images are not read: no light is asked for", loaded.left_out_count));
  // an image found under another name is used, and reported
  for (const auto& [address, name] : loaded.guessed) {
    if (loaded.unread.count(address) == 0)
      others += fmt::format("{}\"{}\" from {}", others.empty() ? "" : ", ", address.substr(0, 80), name);
  }
  if (!others.empty()) notes.push_back("images are read by other names than their addresses': " + others);
  if (loaded.most_side < kMostTexelsOfSide)
    notes.push_back(
        fmt::format("{} images are kept at {} texels a side, so many are they", loaded.images.size(), loaded.most_side));
  return notes;
}

ImageBytes imageBeside(const std::string& scene_path, const std::string& address, SceneBudget& bytes_left) {
  const FileBeside file = findBeside(scene_path, address);
  ImageBytes bytes{{}, {}, file.problem, file.guess};
  if (!file.path.empty()) bytes.own = readSceneFile(file.path, "image", bytes_left);
  return bytes;
}

}  // namespace nlg
