#include "light/sunlight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nlg {
namespace {

// The first of the running sums that is above a number, and how far between it and the one before the number lies. A texel without
// light has no share, and none is drawn.
template <class T>
size_t drawn(const T* sums, size_t count, double number, double* within) {
  const auto at = static_cast<size_t>(std::upper_bound(sums, sums + count, static_cast<T>(number)) - sums);
  const size_t chosen = std::min(at, count - 1);
  const double before = chosen > 0 ? sums[chosen - 1] : 0.0;
  *within = std::clamp((number - before) / std::max(1e-300, sums[chosen] - before), 0.0, 1.0);
  return chosen;
}

}  // namespace

bool comesFromOpenSky(const Scene& scene, const RayScene& rays, const glm::vec3& from, const glm::vec3& direction) {
  if (!rays.hasSkyFaces()) return !rays.isOpaqueAlong(from, direction);  // what it meets need not be known
  const LightHit hit = rays.lightHit(from, direction);
  return hit.kind == LightHit::Kind::nothing || (hit.kind == LightHit::Kind::sky && !scene.light.sky_faces.shines(hit.triangle));
}

bool isInSunlight(const Scene& scene, const RayScene& rays, const glm::dvec3& position_m, const glm::vec3& normal) {
  const std::vector<Sun>& suns = scene.light.suns;
  return std::any_of(suns.begin(), suns.end(), [&](const Sun& sun) {
    return glm::dot(sun.to_sun, normal) > 0.0f && comesFromOpenSky(scene, rays, glm::vec3(position_m), sun.to_sun);
  });
}

SkySampler::SkySampler(const SkyImage& image) : image_(image) {
  // running sums along rows, and over rows by solid angle: a texel is drawn by luminance times solid angle
  double power = 0.0;
  for (int row = 0; row < image.height; ++row) {
    double sum = 0.0;
    for (int column = 0; column < image.width; ++column) {
      sum += luminance(image.texels[static_cast<size_t>(row) * image.width + column]);
      column_sums_.push_back(static_cast<float>(sum));
    }
    float* first = &column_sums_[static_cast<size_t>(row) * image.width];
    for (int column = 0; column < image.width && sum > 0.0; ++column) first[column] /= static_cast<float>(sum);
    row_sums_.push_back(power += sum * image.solidAngle(row));
  }
  if (!(power > 0.0)) {
    row_sums_.clear();
    return;
  }
  for (double& sum : row_sums_) sum /= power;
  per_power_ = static_cast<float>(1.0 / power);
}

SkySampler::Drawn SkySampler::draw(double u, double v) const {
  double row_share = 0.0, column_share = 0.0;
  const size_t row = drawn(row_sums_.data(), row_sums_.size(), u, &row_share);
  const auto width = static_cast<size_t>(image_.width);
  const size_t column = drawn(&column_sums_[row * width], width, v, &column_share);
  // even over the solid angle of the texel
  const double top = std::cos(std::numbers::pi * static_cast<double>(row) / image_.height);
  const double bottom = std::cos(std::numbers::pi * (static_cast<double>(row) + 1.0) / image_.height);
  const double place = std::acos(std::clamp(top + (bottom - top) * row_share, -1.0, 1.0)) / std::numbers::pi;
  return {skyDirection((static_cast<double>(column) + column_share) / static_cast<double>(width), place),
          image_.texels[row * width + column]};
}

}  // namespace nlg
