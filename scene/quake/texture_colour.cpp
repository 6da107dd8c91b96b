#include "scene/quake/texture_colour.h"

#include "scene/image/image_decode.h"
#include "scene/image/texture_image.h"

namespace nlg {

std::optional<ImageMeans> imageMeans(std::string_view bytes, SceneBudget& pixels, const std::string& path,
                                     const std::string& place) {
  PixelWork work(pixels.left());
  DecodedImage image;
  const bool is_decoded = decodeImage(bytes, work, &image).empty();
  pixels.take(work.taken(), path, place);
  if (!is_decoded) return std::nullopt;
  glm::dvec3 linear(0.0), codes(0.0);
  for (size_t at = 0; at < image.pixels.size(); at += 4) {
    const uint8_t* pixel = &image.pixels[at];
    linear += glm::dvec3(linearFromSrgb(pixel[0]), linearFromSrgb(pixel[1]), linearFromSrgb(pixel[2]));
    codes += glm::dvec3(pixel[0], pixel[1], pixel[2]);
  }
  const double count = static_cast<double>(image.pixels.size()) / 4.0;
  return ImageMeans{glm::vec3(linear / count), glm::vec3(codes / (255.0 * count))};
}

}  // namespace nlg
