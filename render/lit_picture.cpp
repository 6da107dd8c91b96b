#include "render/lit_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// Lights one row of pixels.
void lightRow(const Sights& sights, const Lighting& lighting, size_t row, std::vector<ReceivedLight>* received) {
  const size_t per_row = static_cast<size_t>(sights.width) * sights.samples_per_pixel, first = row * per_row;
  // all of a row at once: a lighting that looks up many places together may do so
  std::vector<Receiver> receivers;
  for (size_t i = first; i < first + per_row; ++i) {
    if (sights.samples[i].kind == Sight::Kind::receiver) receivers.push_back(sights.samples[i].receiver);
  }
  if (receivers.empty()) return;
  std::vector<ReceivedLight> lit(receivers.size());
  lighting.light_at(receivers, lit.data());
  const ReceivedLight* next = lit.data();
  for (size_t i = first; i < first + per_row; ++i) {
    if (sights.samples[i].kind == Sight::Kind::receiver) (*received)[i] = *next++;
  }
}

// The mean of what value(pixel) gives for all channels, over the pixels that have receivers; 0 without any.
template <class Value>
double meanOf(const LitPicture& picture, const Value& value) {
  double sum = 0.0;
  uint64_t count = 0;
  for (size_t i = 0; i < picture.irradiance.size(); ++i) {
    if (picture.receiver_share[i] == 0.0f) continue;
    const glm::dvec3 channels(value(i));
    sum += (channels.x + channels.y + channels.z) / 3.0;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace

double luminanceOf(const glm::vec3& rgb) { return 0.2126 * rgb.r + 0.7152 * rgb.g + 0.0722 * rgb.b; }

double medianOf(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<ReceivedLight> lightSamples(const Sights& sights, const Lighting& lighting, int thread_count) {
  std::vector<ReceivedLight> received(sights.samples.size());
  parallelFor(sights.height, thread_count, [&](uint64_t row, int) { lightRow(sights, lighting, row, &received); });
  return received;
}

LitPicture pictureOf(const Sights& sights, const std::string& method, const std::vector<ReceivedLight>& received) {
  LitPicture picture;
  picture.method = method;
  picture.width = sights.width;
  picture.height = sights.height;
  uint64_t receivers = 0, unlit = 0;
  // samples of a pixel become means: radiance over all samples, irradiance over those that receive light
  for (size_t first = 0; first < sights.samples.size(); first += sights.samples_per_pixel) {
    glm::vec3 radiance(0.0f), irradiance(0.0f), variance(0.0f);
    int count = 0, solid = 0;
    for (size_t i = first; i < first + sights.samples_per_pixel; ++i) {
      const Sight& sight = sights.samples[i];
      radiance += sight.shine;
      solid += sight.kind == Sight::Kind::solid;
      if (sight.kind != Sight::Kind::receiver) continue;
      // diffuse: radiance is albedo times irradiance over pi
      radiance += sight.albedo * received[i].irradiance / kPi;
      irradiance += received[i].irradiance;
      // samples are independent: variances add
      variance += received[i].deviation * received[i].deviation;
      unlit += !received[i].is_lit;
      ++count;
    }
    receivers += count;
    const auto of_samples = 1.0f / static_cast<float>(sights.samples_per_pixel);
    const auto of_receivers = 1.0f / static_cast<float>(std::max(1, count));
    picture.radiance.push_back(radiance * of_samples);
    picture.irradiance.push_back(irradiance * of_receivers);
    picture.deviation.push_back(glm::sqrt(variance) * of_receivers);
    picture.receiver_share.push_back(static_cast<float>(count) * of_samples);
    // a pixel shows solid only if all of its samples do
    picture.in_solid.push_back(solid == sights.samples_per_pixel);
  }
  if (receivers > 0) picture.unlit_share = static_cast<double>(unlit) / static_cast<double>(receivers);
  return picture;
}

LitPicture lightPicture(const Sights& sights, const Lighting& lighting, int thread_count) {
  return pictureOf(sights, lighting.name, lightSamples(sights, lighting, thread_count));
}

double irradianceRms(const LitPicture& picture) {
  return std::sqrt(meanOf(picture, [&](size_t i) { return picture.irradiance[i] * picture.irradiance[i]; }));
}

PictureError pictureError(const LitPicture& picture, const LitPicture& truth) {
  const double rms = irradianceRms(truth);
  if (!(rms > 0.0)) return {};
  const auto difference = [&](size_t i) { return glm::dvec3(picture.irradiance[i] - truth.irradiance[i]); };
  return {std::sqrt(meanOf(truth, [&](size_t i) { return difference(i) * difference(i); })) / rms,
          meanOf(truth, difference) / rms,
          std::sqrt(meanOf(truth, [&](size_t i) { return truth.deviation[i] * truth.deviation[i]; })) / rms};
}

}  // namespace nlg
