#include "render/tone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/picture/legend.h"
#include "scene/model/scene_light.h"
#include "scene/model/surface_look.h"
#include "scene/model/texture_image.h"

namespace nlg {
namespace {

using glm::vec3, std::max, std::min;
#include "render/neutral_tone.glsl"

constexpr double kMiddleGrey = 0.18;

constexpr Colour kNoReceiver{120, 120, 120};

// Colours by pixel: colour(pixel) where there are receivers.
template <class ColourOf>
Image mapOf(const LitPicture& picture, const ColourOf& colour) {
  Image image(picture.width, picture.height, kNoReceiver);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const size_t pixel = static_cast<size_t>(y) * picture.width + x;
      if (picture.in_solid[pixel]) image.set(x, y, hatchColour(x, y));
      if (picture.receiver_share[pixel] > 0.0f) image.set(x, y, colour(pixel));
    }
  }
  return image;
}

double errorOf(const LitPicture& picture, const LitPicture& truth, size_t pixel, ErrorKind kind) {
  const glm::vec3 difference = picture.irradiance[pixel] - truth.irradiance[pixel];
  if (kind == ErrorKind::with_sign) return luminanceOf(difference);
  return glm::length(glm::dvec3(difference)) / std::sqrt(3.0);
}

}  // namespace

double leastAdapted(const Scene& scene) {
  const SceneLight& light = scene.light;
  // irradiance that each source gives alone: sky and surfaces over a hemisphere, the sun facing it, a lamp a metre away
  double most = std::numbers::pi * max(luminance(light.sky.zenith), luminance(light.sky.horizon));
  for (const Sun& sun : light.suns) most = max<double>(most, luminance(sun.irradiance));
  for (const Lamp& lamp : light.lamps) most = max<double>(most, luminance(lamp.intensity));
  for (const glm::vec3& shine : light.sky_faces.shine) most = max(most, std::numbers::pi * luminance(shine));
  for (const glm::vec3& texel : light.baked.texels) most = max(most, std::numbers::pi * luminance(texel));
  for (const glm::vec3& vertex : light.baked.vertex_light) most = max(most, std::numbers::pi * luminance(vertex));
  // a metre before a small surface; of a large one no more than the surface itself sends
  std::vector<double> brightest(scene.materials.size(), 0.0), power(scene.materials.size(), 0.0);
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const uint32_t material = scene.triangle_material[t];
    if (scene.materials[material].emissive == glm::vec3(0.0f)) continue;
    const glm::uvec3& corners = scene.triangles[t];
    const glm::vec3& corner = scene.positions[corners.x];
    const double shine = luminance(emissionAt(scene, t, 1.0f / 3.0f, 1.0f / 3.0f));
    brightest[material] = max(brightest[material], shine);
    power[material] +=
        0.5 * shine * glm::length(glm::cross(scene.positions[corners.y] - corner, scene.positions[corners.z] - corner));
  }
  for (size_t m = 0; m < power.size(); ++m) most = max(most, min(power[m], std::numbers::pi * brightest[m]));
  return kLeastOfOpen * most;
}

double automaticExposure(const LitPicture& picture, double least) {
  std::vector<double> luminances;
  for (size_t i = 0; i < picture.radiance.size(); ++i) {
    const double luminance = luminanceOf(picture.radiance[i]);
    if (picture.receiver_share[i] > 0.0f && luminance > 0.0) luminances.push_back(luminance);
  }
  return luminances.empty() ? 1.0 : kMiddleGrey / max(medianOf(std::move(luminances)), least / std::numbers::pi);
}

double panelExposure(const std::vector<const LitPicture*>& pictures, double least) {
  const auto isNoisy = [](const LitPicture* picture) {
    return std::any_of(picture->deviation.begin(), picture->deviation.end(), [](const vec3& d) { return d != vec3(0.0f); });
  };
  const auto clean = std::find_if_not(pictures.begin(), pictures.end(), isNoisy);
  return automaticExposure(clean != pictures.end() ? **clean : *pictures.front(), least);
}

Image toneMapped(const LitPicture& picture, double exposure) {
  Image image(picture.width, picture.height, kBlack);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const size_t pixel = static_cast<size_t>(y) * picture.width + x;
      const vec3 shown = neutralTone(vec3(exposure * glm::dvec3(picture.radiance[pixel])));
      image.set(x, y,
                picture.in_solid[pixel] ? hatchColour(x, y)
                                        : Colour{srgbFromLinear(shown.r), srgbFromLinear(shown.g), srgbFromLinear(shown.b)});
    }
  }
  return image;
}

Image errorMap(const LitPicture& picture, const LitPicture& truth, ErrorKind kind, double range) {
  return errorMapUpTo(range * irradianceRms(truth), picture, truth, kind);
}

Image errorMapUpTo(double full, const LitPicture& picture, const LitPicture& truth, ErrorKind kind) {
  const double unit = full > 0.0 ? 1.0 / full : 0.0;
  return mapOf(truth, [&](size_t pixel) {
    const double value = errorOf(picture, truth, pixel, kind) * unit;
    return kind == ErrorKind::with_sign ? diverging(value) : viridis(value);
  });
}

double nextScale(double value) {
  const double least = std::clamp(value, 1e-6, 1e6);
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least) return factor * decade;
  }
  return 10.0 * decade;
}

double errorRange(const std::vector<const LitPicture*>& pictures, const LitPicture& truth) {
  constexpr double kExceeding = 0.05;
  const double rms = irradianceRms(truth);
  std::vector<double> errors;
  for (const LitPicture* picture : pictures) {
    for (size_t i = 0; i < truth.irradiance.size() && rms > 0.0; ++i) {
      if (truth.receiver_share[i] > 0.0f) errors.push_back(errorOf(*picture, truth, i, ErrorKind::absolute) / rms);
    }
  }
  if (errors.empty()) return 1.0;
  const auto at = errors.begin() + static_cast<ptrdiff_t>(static_cast<double>(errors.size() - 1) * (1.0 - kExceeding));
  std::nth_element(errors.begin(), at, errors.end());
  return nextScale(*at);
}

}  // namespace nlg
