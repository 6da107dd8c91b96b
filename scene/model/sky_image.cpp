#include "scene/model/sky_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene/model/scene_light.h"

namespace nlg {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSunPatch = 2.5 * kPi / 180.0;  // radians from the brightest texel: a sun of an image is blurred by its lens
constexpr double kSunRing = 2.0 * kSunPatch;     // up to which what surrounds it is asked for
constexpr double kSunShare = 0.05;               // of the image's light
constexpr double kLeastSunRadius = 0.00465;      // the sun's own

// Calls with every column of the image that the interval touches, and how much of that column it covers.
template <class Visit>
void forEachOverlap(double begin, double end, int count, const Visit& visit) {
  for (auto at = static_cast<int>(std::floor(begin)); at < end; ++at) {
    const double share = std::min(end, at + 1.0) - std::max(begin, static_cast<double>(at));
    if (share > 0.0) visit((at % count + count) % count, share);
  }
}

// Of a band between two shares of the image's height, over 2 pi.
double bandHeight(double from, double to) { return std::cos(kPi * from) - std::cos(kPi * to); }

}  // namespace

glm::vec2 skyPlace(const glm::vec3& direction) {
  const float across = std::hypot(direction.x, direction.z);
  return {0.5f + std::atan2(direction.z, direction.x) / static_cast<float>(2.0 * kPi),
          std::atan2(across, direction.y) / static_cast<float>(kPi)};
}

glm::vec3 skyDirection(double column, double row) {
  const double azimuth = 2.0 * kPi * (column - 0.5), sine = std::sin(kPi * row);
  return glm::vec3(glm::dvec3(sine * std::cos(azimuth), std::cos(kPi * row), sine * std::sin(azimuth)));
}

const glm::vec3& SkyImage::radiance(const glm::vec3& direction) const {
  const glm::vec2 place = skyPlace(direction);
  const int column = std::clamp(static_cast<int>(place.x * static_cast<float>(width)), 0, width - 1);
  const int row = std::clamp(static_cast<int>(place.y * static_cast<float>(height)), 0, height - 1);
  return texels[static_cast<size_t>(row) * width + column];
}

double SkyImage::solidAngle(int row) const {
  return 2.0 * kPi / width * bandHeight(static_cast<double>(row) / height, (row + 1.0) / height);
}

Sky skyOfImage(SkyImage image) {
  // least squares over solid angle, which is even over the height y
  glm::dvec3 ground(0.0), mean(0.0), moment(0.0);
  for (int row = 0; row < image.height; ++row) {
    const double from = std::cos(kPi * row / image.height), to = std::cos(kPi * (row + 1.0) / image.height);
    glm::dvec3 colour(0.0);
    for (int column = 0; column < image.width; ++column)
      colour += glm::dvec3(image.texels[static_cast<size_t>(row) * image.width + column]) / static_cast<double>(image.width);
    const double above = std::max(0.0, from) - std::max(0.0, to);
    ground += colour * (from - to - above);
    mean += colour * above;
    moment += colour * (above * 0.5 * (std::max(0.0, from) + std::max(0.0, to)));
  }
  const glm::dvec3 rise = 12.0 * (moment - 0.5 * mean), horizon = mean - 0.5 * rise;
  const auto radiance = [](const glm::dvec3& colour) { return glm::vec3(glm::max(glm::dvec3(0.0), colour)); };
  return {radiance(horizon + rise), radiance(horizon), radiance(ground), std::move(image)};
}

std::optional<Sun> takeSun(SkyImage* image) {
  const auto brighter = [](const glm::vec3& a, const glm::vec3& b) { return luminance(a) < luminance(b); };
  const auto brightest = std::max_element(image->texels.begin(), image->texels.end(), brighter) - image->texels.begin();
  const auto directionOf = [&](size_t texel) {
    const size_t row = texel / image->width, column = texel % image->width;
    return glm::dvec3(skyDirection((column + 0.5) / image->width, (row + 0.5) / image->height));
  };
  // radiance around the brightest texel: the patch that may hold the sun, and a ring that tells the sky beside it
  const glm::dvec3 middle = directionOf(brightest);
  glm::dvec3 around(0.0);
  double ring = 0.0, all = 0.0;
  std::vector<size_t> patch;
  for (size_t texel = 0; texel < image->texels.size(); ++texel) {
    const double solid_angle = image->solidAngle(static_cast<int>(texel / image->width));
    const double cosine = glm::dot(directionOf(texel), middle);
    all += solid_angle * luminance(image->texels[texel]);
    if (cosine >= std::cos(kSunPatch)) {
      patch.push_back(texel);
    } else if (cosine >= std::cos(kSunRing)) {
      around += solid_angle * glm::dvec3(image->texels[texel]);
      ring += solid_angle;
    }
  }
  // of an image so small that the patch has no ring: who would say what stands out of it
  if (ring == 0.0) return std::nullopt;
  // flux is what exceeds the ring, over solid angle: irradiance of a plane that faces the sun
  const glm::vec3 surrounding(around / ring);
  glm::dvec3 flux(0.0), to_sun(0.0);
  for (const size_t texel : patch) {
    const glm::dvec3 excess(glm::max(glm::vec3(0.0f), image->texels[texel] - surrounding));
    const double solid_angle = image->solidAngle(static_cast<int>(texel / image->width));
    flux += solid_angle * excess;
    to_sun += solid_angle * luminance(glm::vec3(excess)) * directionOf(texel);
  }
  // a bright cloud is no sun: it holds too small a share of all light
  if (!(luminance(glm::vec3(flux)) >= kSunShare * all) || all == 0.0) return std::nullopt;
  // the patch falls to its surroundings, so that the sun counts once; its spread gives the disc
  const glm::dvec3 centre = glm::normalize(to_sun);
  double spread = 0.0;
  for (const size_t texel : patch) {
    const glm::vec3 excess = glm::max(glm::vec3(0.0f), image->texels[texel] - surrounding);
    const glm::dvec3 off = directionOf(texel) - centre;
    spread += image->solidAngle(static_cast<int>(texel / image->width)) * luminance(excess) * glm::dot(off, off);
    image->texels[texel] = glm::min(image->texels[texel], surrounding);
  }
  Sun sun;
  sun.to_sun = glm::vec3(centre);
  sun.irradiance = glm::vec3(flux);
  // the mean square of distances from a disc's middle is half of its radius squared
  const double radius = std::sqrt(2.0 * spread / luminance(glm::vec3(flux)));
  sun.angular_radius = static_cast<float>(std::clamp(radius, kLeastSunRadius, kSunPatch));
  return sun;
}

SkyReduction::SkyReduction(int width, int height, double turn) : width_(width), height_(height), turn_(turn) {
  image_.width = std::min(width, kMostSkyColumns);
  image_.height = std::min(height, kMostSkyRows);
  sums_.assign(static_cast<size_t>(image_.width) * image_.height, glm::dvec3(0.0));
}

void SkyReduction::addRow(int row, const float* rgb) {
  // box filter along the row: the turn shifts columns by a fraction of a texel
  line_.assign(image_.width, glm::dvec3(0.0));
  const double columns = static_cast<double>(image_.width) / width_;
  const double shift = (turn_ - std::floor(turn_)) * image_.width;
  for (int x = 0; x < width_; ++x) {
    glm::dvec3 radiance;
    for (int channel = 0; channel < 3; ++channel) {
      const double value = rgb[3 * static_cast<size_t>(x) + channel];
      // negative, infinite and NaN values count as 0, and are reported
      const bool is_radiance = value >= 0.0 && value <= kBrightest;
      radiance[channel] = is_radiance ? value : 0.0;
      mended_ += !is_radiance;
    }
    forEachOverlap(shift + x * columns, shift + (x + 1) * columns, image_.width,
                   [&](int column, double share) { line_[column] += share * radiance; });
  }
  // rows share by solid angle, which is in proportion to the height of their band: the flux of the sky is kept
  const double rows = static_cast<double>(image_.height) / height_;
  const double top = row * rows, bottom = (row + 1) * rows;
  for (int to = static_cast<int>(top); to < std::min<double>(bottom, image_.height); ++to) {
    const double band = bandHeight(std::max<double>(top, to) / image_.height, std::min(bottom, to + 1.0) / image_.height);
    const double share = band / bandHeight(static_cast<double>(to) / image_.height, (to + 1.0) / image_.height);
    for (int column = 0; column < image_.width; ++column)
      sums_[static_cast<size_t>(to) * image_.width + column] += share * line_[column];
  }
}

SkyImage SkyReduction::finish() const {
  SkyImage image = image_;
  image.texels.assign(sums_.begin(), sums_.end());
  return image;
}

}  // namespace nlg
