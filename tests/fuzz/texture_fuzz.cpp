// Hostile images, PNG, JPEG, WebP and Targa: an image is decoded whole and kept small, or it is said what is wrong with it; it has means
// between black and white, or none, or it asks for too many pixels.
#include "scene/quake/bsp_looks.h"

#include "scene/image/image_loader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/scene/image/hand_built_images.h"

namespace nlg::fuzz {
namespace {

// far less than a scene may have, so that the end of the budget is met, too
constexpr uint64_t kMostPixels = uint64_t{1} << 22;

void check(const glm::vec3& mean) {
  for (int channel = 0; channel < 3; ++channel)
    FUZZ_CHECK(mean[channel] >= 0.0f && mean[channel] <= 1.0f, std::to_string(mean[channel]));
}

void decode(std::string_view bytes) {
  PixelWork work(kMostPixels);
  DecodedImage image;
  const std::string problem = decodeImage(bytes, work, &image);
  const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
  FUZZ_CHECK(image.pixels.size() == 4 * count && (count > 0) == problem.empty(), problem);
  if (count == 0) return;
  for (const int most_side : {1, 7, kMostTexelsOfSide}) {
    const TextureImage kept = reducedImage(image, {KeptAs::Colour::srgb, KeptAs::Opacity::cut, 128, {}}, most_side);
    FUZZ_CHECK(kept.width == std::min(image.width, most_side) && kept.height == std::min(image.height, most_side), "sides");
    FUZZ_CHECK(kept.texels.size() == static_cast<size_t>(kept.width) * static_cast<size_t>(kept.height), "texels");
  }
}

void readMeans(std::string_view bytes) {
  SceneBudget pixels("pixels of textures", kMostPixels);
  const std::optional<ImageMeans> means = imageMeans(bytes, pixels, "level.pk3", "image");
  if (!means) return;
  check(means->linear);
  check(means->code);
}

}  // namespace

void readOne(std::string_view bytes) {
  decode(bytes);
  isTaken([&] { readMeans(bytes); });
}

Seeds seeds() {
  return {{"colours.tga", targa(2, 2, 1, 24, std::string("\0\0\0\xff\xff\xff", 6))},
          {"transparent.tga", targa(2, 1, 1, 32, std::string("\xff\0\0\x80", 4))},
          {"grey.tga", targa(3, 1, 2, 8, "\xbc\xbc")},
          {"packed.tga", targa(10, 2, 2, 24, std::string("\x82\0\0\xff\0\0\0\0", 8))},
          {"packed_grey.tga", targa(11, 3, 2, 8, "\x81\x10\x03\x20\x30\x40\x50")},
          {"colours.png", png(2, 2, pixels(4, "\x10\x80\xf0\x40"))},
          {"colours.webp", webp(2, 2, pixels(4, "\x10\x80\xf0\x40"))},
          {"plain.jpg", jpeg(9, 10, 20, 30)},
          {"progressive.jpg", jpeg(17, 10, 20, 30, JpegKind::progressive)}};
}

std::string mutated(std::string bytes, size_t max_size, Random&) { return mutatedBlindly(std::move(bytes), max_size); }

}  // namespace nlg::fuzz
