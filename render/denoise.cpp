#include "render/denoise.h"

#include <algorithm>
#include <cmath>

#include "render/lit_picture.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr int kRounds = 5;           // steps of 1, 2, 4, 8, 16 pixels
constexpr int kNoiseReach = 3;       // pixels: a pixel's own sets of rays tell little of its noise where light comes seldom
constexpr float kDeviations = 4.0f;  // of what counts as noise
constexpr float kSharpNormals = 32.0f;
constexpr float kPlaneShare = 0.005f;                                  // of the distance from the eye
constexpr float kSpline[] = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};  // by distance in steps

// A picture while it is filtered, by pixel.
struct Filtered {
  std::vector<glm::vec3> irradiance;
  std::vector<float> variance;  // of its luminance
};

class Filter {
 public:
  Filter(const Sights& sights, const Camera& camera, int thread_count)
      : sights_(sights), eye_m_(camera.eye_m), thread_count_(thread_count) {}

  // Noise around each pixel.
  void spreadVariance(Filtered* picture) const {
    const Filtered before = *picture;
    forEach([&](int x, int y, size_t i) {
      float sum = 0.0f, weights = 0.0f;
      forEachAround(x, y, kNoiseReach, 1, [&](size_t j, int, int) {
        const float weight = likeness(i, j);
        sum += weight * before.variance[j];
        weights += weight;
      });
      picture->variance[i] = sum / weights;
    });
  }

  void smooth(int step, Filtered* picture) const {
    const Filtered before = *picture;
    forEach([&](int x, int y, size_t i) {
      const auto own = static_cast<float>(luminanceOf(before.irradiance[i]));
      // what is dark and without noise takes nothing from what is not: black is kept black
      const float allowed = kDeviations * std::sqrt(before.variance[i]) + 1e-12f;
      glm::vec3 sum(0.0f);
      float variance = 0.0f, weights = 0.0f;
      forEachAround(x, y, 2, step, [&](size_t j, int dx, int dy) {
        const float difference = std::fabs(static_cast<float>(luminanceOf(before.irradiance[j])) - own);
        const float weight = kSpline[std::abs(dx)] * kSpline[std::abs(dy)] * likeness(i, j) * std::exp(-difference / allowed);
        sum += weight * before.irradiance[j];
        variance += weight * weight * before.variance[j];
        weights += weight;
      });
      picture->irradiance[i] = sum / weights;
      picture->variance[i] = variance / (weights * weights);
    });
  }

 private:
  bool isReceiver(size_t i) const { return sights_.samples[i].kind == Sight::Kind::receiver; }

  // How far two pixels show one surface, 0..1; of a pixel and itself 1.
  float likeness(size_t i, size_t j) const {
    const Receiver &a = sights_.samples[i].receiver, &b = sights_.samples[j].receiver;
    const float off_plane = std::fabs(glm::dot(a.normal, glm::vec3(b.position_m - a.position_m)));
    const float unit = kPlaneShare * static_cast<float>(glm::distance(a.position_m, eye_m_)) + 1e-6f;
    const float turned = std::clamp(glm::dot(a.normal, b.normal), 0.0f, 1.0f);
    return std::pow(turned, kSharpNormals) * std::exp(-off_plane / unit);
  }

  template <class Visit>
  void forEach(const Visit& visit) const {
    parallelFor(sights_.height, thread_count_, [&](uint64_t row, int) {
      for (int x = 0; x < sights_.width; ++x) {
        const size_t i = row * sights_.width + x;
        if (isReceiver(i)) visit(x, static_cast<int>(row), i);
      }
    });
  }

  template <class Visit>
  void forEachAround(int x, int y, int reach, int step, const Visit& visit) const {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const int at_x = x + dx * step, at_y = y + dy * step;
        if (at_x < 0 || at_y < 0 || at_x >= sights_.width || at_y >= sights_.height) continue;
        const size_t j = static_cast<size_t>(at_y) * sights_.width + at_x;
        if (isReceiver(j)) visit(j, dx, dy);
      }
    }
  }

  const Sights& sights_;
  const glm::dvec3 eye_m_;
  const int thread_count_;
};

}  // namespace

std::vector<LightAnswer> denoised(const Sights& sights, const Camera& camera, std::vector<LightAnswer> light, int thread_count) {
  NLG_CHECK(sights.samples_per_pixel, ==, 1);
  Filtered picture;
  for (const LightAnswer& received : light) {
    picture.irradiance.push_back(received.irradiance);
    const auto deviation = static_cast<float>(luminanceOf(received.deviation));
    picture.variance.push_back(deviation * deviation);
  }
  const Filter filter(sights, camera, thread_count);
  filter.spreadVariance(&picture);
  for (int round = 0; round < kRounds; ++round) filter.smooth(1 << round, &picture);
  for (size_t i = 0; i < light.size(); ++i) light[i].irradiance = picture.irradiance[i];
  return light;
}

}  // namespace nlg
