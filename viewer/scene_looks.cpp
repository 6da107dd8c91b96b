#include "viewer/scene_looks.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

constexpr size_t kMostImageBytes = 8u << 20;  // of a page, before base64
constexpr int kLargestSide = 256, kSmallestSide = 4;

int sideOf(size_t image_count) {
  int side = kLargestSide;
  while (side > kSmallestSide && 4u * side * side * image_count > kMostImageBytes) side /= 2;
  return side;
}

// Means over evenly spread samples, as many as the image has texels there.
void appendLayer(const TextureImage& image, int side, std::vector<uint8_t>* bytes) {
  const int across = std::max(1, (image.width + side - 1) / side), down = std::max(1, (image.height + side - 1) / side);
  const TextureUse clamped{0, TextureWrap::clamp, TextureWrap::clamp};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      glm::vec4 sum(0.0f);
      for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i)
          sum += texelAt(image, clamped, glm::vec2(x + (i + 0.5f) / across, y + (j + 0.5f) / down) / static_cast<float>(side));
      }
      sum /= static_cast<float>(across * down);
      for (int c = 0; c < 3; ++c) bytes->push_back(srgbFromLinear(sum[c]));
      bytes->push_back(static_cast<uint8_t>(std::lround(255.0f * sum.a)));
    }
  }
}

float wrapCode(const TextureUse& use) { return 3.0f * static_cast<float>(use.wrap_u) + static_cast<float>(use.wrap_v); }

template <class Vector>
std::vector<float> numbersOf(const std::vector<Vector>& vectors) {
  std::vector<float> numbers;
  for (const Vector& vector : vectors) {
    for (int i = 0; i < vector.length(); ++i) numbers.push_back(vector[i]);
  }
  return numbers;
}

}  // namespace

void addLooks(const Scene& scene, DataScript* script) {
  const bool has_transmissive = std::any_of(scene.materials.begin(), scene.materials.end(),
                                            [](const Material& m) { return m.transmissive != Transmissive::none; });
  if (scene.images.empty() && scene.vertex_colours.empty() && !has_transmissive) return;
  std::vector<float> looks;
  for (const Material& material : scene.materials) {
    // the page draws a transmissive surface's colour where it is not transparent: what it transmits in that colour is let through
    // as it is
    const float transparent = 1.0f - material.opacity * (1.0f - material.transmission);
    looks.insert(looks.end(), {static_cast<float>(material.base_image.image + 1), wrapCode(material.base_image),
                               static_cast<float>(material.emissive_image.image + 1), wrapCode(material.emissive_image),
                               material.transmissive == Transmissive::none ? -1.0f : transparent});
  }
  const int side = sideOf(scene.images.size());
  std::vector<uint8_t> texels;
  for (const TextureImage& image : scene.images) appendLayer(image, side, &texels);
  script->add("material_looks", looks);
  script->add("base_places", numbersOf(scene.base_places));
  script->add("emissive_places", numbersOf(scene.emissive_places));
  script->add("vertex_colours", numbersOf(scene.vertex_colours));
  script->add("images", texels);
  script->facts["images_of"] = {{"side", side}, {"count", scene.images.size()}};
}

}  // namespace nlg
