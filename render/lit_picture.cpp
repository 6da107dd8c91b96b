#include "render/lit_picture.h"

#include <algorithm>
#include <cmath>

#include "light/directions.h"

namespace nlg {
namespace {

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

std::vector<LightAnswer> lightSamples(const Sights& sights, const LightAt& light_at, int thread_count) {
  std::vector<Receiver> receivers;
  for (const Sight& sight : sights.samples) {
    if (sight.kind == Sight::Kind::receiver) receivers.push_back(sight.receiver);
  }
  const std::vector<LightAnswer> answers = answersAt(light_at, receivers, thread_count);
  std::vector<LightAnswer> by_sample(sights.samples.size());
  for (size_t i = 0, next = 0; i < by_sample.size(); ++i) {
    if (sights.samples[i].kind == Sight::Kind::receiver) by_sample[i] = answers[next++];
  }
  return by_sample;
}

LitPicture pictureOf(const Sights& sights, const std::string& method, const std::vector<LightAnswer>& received) {
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
      unlit += !received[i].isLit();
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

LitPicture lightPicture(const Sights& sights, const std::string& method, const LightAt& light_at, int thread_count) {
  return pictureOf(sights, method, lightSamples(sights, light_at, thread_count));
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
