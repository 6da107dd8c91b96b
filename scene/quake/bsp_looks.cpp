#include "scene/quake/bsp_looks.h"

#include "scene/image/image_decode.h"
#include "scene/model/texture_image.h"
#include "scene/quake/bsp_light.h"

namespace nlg {
namespace {

constexpr const char* kImageSuffixes[] = {".tga", ".jpg", ".png"};
constexpr size_t kMaxTextureBytes = size_t{64} << 20;

}  // namespace

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

BspLooks::BspLooks(const Pk3Archives& archives, ImageNeed need)
    : archives_(archives), need_(need), scripts_(readShaderScripts(archives)) {}

const ShaderScript* BspLooks::scriptOf(const std::string& shader) const {
  const auto found = scripts_.find(shaderKey(shader));
  return found == scripts_.end() ? nullptr : &found->second;
}

const std::optional<ImageMeans>& BspLooks::entryMeans(const std::string& entry) const {
  const auto known = images_.find(entry);
  if (known != images_.end()) return known->second;
  const std::string bytes = archives_.read(entry, kMaxTextureBytes);
  return images_.emplace(entry, imageMeans(bytes, pixels_left_, archives_.path(), entry)).first->second;
}

std::optional<ImageMeans> BspLooks::image(const std::string& name) const {
  for (const char* suffix : kImageSuffixes) {
    if (need_ == ImageNeed::geometry || !archives_.has(name + suffix)) continue;
    const std::optional<ImageMeans>& means = entryMeans(name + suffix);
    if (means) return means;
  }
  return std::nullopt;
}

std::vector<std::string> BspLooks::textureNames(const std::string& shader) const {
  const ShaderScript* script = scriptOf(shader);
  std::vector<std::string> names;
  if (script != nullptr) names = script->textures;
  names.push_back(shaderKey(shader));
  return names;
}

std::vector<std::string> BspLooks::images(const std::string& shader) const {
  std::vector<std::string> entries;
  const ShaderScript* script = scriptOf(shader);
  const bool is_cut = script != nullptr && !script->cut.texture.empty();
  for (const std::string& name : is_cut ? std::vector{script->cut.texture} : textureNames(shader)) {
    for (const char* suffix : kImageSuffixes) {
      if (archives_.has(name + suffix)) entries.push_back(name + suffix);
    }
  }
  return entries;
}

KeptAs BspLooks::keptAs(const std::string& shader) const {
  const ShaderScript* script = scriptOf(shader);
  if (script == nullptr || script->cut.texture.empty()) return {};
  return {KeptAs::Colour::srgb, KeptAs::Opacity::cut, script->cut.least_code, {}};
}

LoadedImages BspLooks::load(const ImageLoader& images) const {
  const auto open = [&](const std::string& entry) {
    const std::string bytes = archives_.read(entry, kMaxTextureBytes);
    return ImageBytes{{bytes.begin(), bytes.end()}, {}, {}, {}};
  };
  return images.load(open, pixels_left_, archives_.path());
}

std::optional<DecodedImage> BspLooks::page(const std::string& name) const {
  for (const char* suffix : kImageSuffixes) {
    if (!archives_.has(name + suffix)) continue;
    PixelWork work(pixels_left_.left());
    DecodedImage image;
    const bool is_decoded = decodeImage(archives_.read(name + suffix, kMaxTextureBytes), work, &image).empty();
    pixels_left_.take(work.taken(), archives_.path(), name + suffix);
    if (is_decoded) return image;
  }
  return std::nullopt;
}

std::optional<glm::vec3> BspLooks::textureColour(const std::string& shader) const {
  for (const std::string& name : textureNames(shader)) {
    const std::optional<ImageMeans> means = image(name);
    if (means) return means->linear;
  }
  return std::nullopt;
}

glm::vec3 BspLooks::lightHue(const std::string& shader, const ScriptLight& light) const {
  if (light.colour) return hueOf(*light.colour);
  std::vector<std::string> names = textureNames(shader);
  if (!light.image.empty()) names.insert(names.begin(), light.image);
  for (const std::string& name : names) {
    const std::optional<ImageMeans> means = image(name);
    if (means) return hueOf(means->code);
  }
  return glm::vec3(1.0f);
}

glm::vec3 BspLooks::emission(const std::string& shader) const {
  const ShaderScript* script = scriptOf(shader);
  if (script == nullptr || !(script->light.surface_light > 0.0)) return glm::vec3(0.0f);
  return lightHue(shader, script->light) * static_cast<float>(surfaceRadiance(script->light.surface_light));
}

std::optional<Sky> BspLooks::skyBox(const std::string& stem) const {
  const std::optional<ImageMeans> up = image(stem + "_up"), down = image(stem + "_dn");
  glm::vec3 sides(0.0f);
  int side_count = 0;
  for (const char* side : {"_rt", "_lf", "_ft", "_bk"}) {
    const std::optional<ImageMeans> means = image(stem + side);
    if (!means) continue;
    sides += means->linear;
    ++side_count;
  }
  if (side_count == 0 && !up) return std::nullopt;
  const glm::vec3 around = side_count > 0 ? sides / static_cast<float>(side_count) : up->linear;
  return Sky{up ? up->linear : around, around, down ? down->linear : around};
}

Sky BspLooks::sky(const std::string& shader) const {
  const ShaderScript* script = scriptOf(shader);
  if (script == nullptr) return {};
  const ScriptLight& light = script->light;
  const double radiance = surfaceRadiance(light.surface_light) + skyRadiance(light.sky_light);
  if (radiance > 0.0) {
    const glm::vec3 even = lightHue(shader, light) * static_cast<float>(radiance);
    return {even, even, even};
  }
  if (!light.sky_box.empty()) {
    const std::optional<Sky> box = skyBox(light.sky_box);
    if (box) return *box;
  }
  const glm::vec3 even = textureColour(shader).value_or(glm::vec3(0.0f));
  return {even, even, even};
}

}  // namespace nlg
