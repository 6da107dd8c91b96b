#include "render/tone.h"

#include <algorithm>
#include <cmath>

#include "datagen/view/legend.h"

namespace nlg {
namespace {

constexpr Colour kNoReceiver{120, 120, 120};

uint8_t srgbByte(double linear) {
  const double value = std::clamp(linear, 0.0, 1.0);
  const double encoded = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
  return static_cast<uint8_t>(std::lround(255.0 * encoded));
}

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

double automaticExposure(const LitPicture& picture) {
  constexpr double kMiddleGrey = 0.18;
  std::vector<double> luminances;
  for (size_t i = 0; i < picture.radiance.size(); ++i) {
    const double luminance = luminanceOf(picture.radiance[i]);
    if (picture.receiver_share[i] > 0.0f && luminance > 0.0) luminances.push_back(luminance);
  }
  return luminances.empty() ? 1.0 : kMiddleGrey / medianOf(std::move(luminances));
}

Image toneMapped(const LitPicture& picture, double exposure) {
  Image image(picture.width, picture.height, kBlack);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const size_t pixel = static_cast<size_t>(y) * picture.width + x;
      const glm::dvec3 shown = exposure * glm::dvec3(picture.radiance[pixel]);
      image.set(x, y,
                picture.in_solid[pixel] ? hatchColour(x, y) : Colour{srgbByte(shown.r), srgbByte(shown.g), srgbByte(shown.b)});
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

Image shareMap(const LitPicture& shares, const LitPicture& shading) {
  const Image grey = toneMapped(shading, automaticExposure(shading));
  return mapOf(shares, [&](size_t pixel) {
    const int x = static_cast<int>(pixel % shares.width), y = static_cast<int>(pixel / shares.width);
    const double share = shares.irradiance[pixel].r;
    const auto level = static_cast<uint8_t>(40.0 + 0.8 * lightness(grey.at(x, y)));
    return share > 0.0 ? mix(viridis(share), Colour{level, level, level}, 0.25) : Colour{level, level, level};
  });
}

}  // namespace nlg
