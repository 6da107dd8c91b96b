#include "render/lit_picture.h"

#include <algorithm>
#include <cmath>

#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

// Lights one row of pixels; returns how many of its receivers are unlit and how many there are.
struct RowCount {
  uint64_t receivers = 0, unlit = 0;
};

RowCount lightRow(const Sights& sights, const Lighting& lighting, size_t row, LitPicture* picture) {
  const size_t per_row = static_cast<size_t>(sights.width) * sights.samples_per_pixel;
  const Sight* samples = &sights.samples[row * per_row];
  // all of a row at once: a lighting that looks up many places together may do so
  std::vector<Receiver> receivers;
  for (size_t i = 0; i < per_row; ++i) {
    if (samples[i].kind == Sight::Kind::receiver) receivers.push_back(samples[i].receiver);
  }
  std::vector<ReceivedLight> received(receivers.size());
  if (!receivers.empty()) lighting.light_at(receivers, received.data());
  const ReceivedLight* next = received.data();
  for (int x = 0; x < sights.width; ++x) {
    const size_t pixel = row * sights.width + x;
    glm::vec3 radiance(0.0f), irradiance(0.0f), variance(0.0f);
    int count = 0, solid = 0;
    for (int s = 0; s < sights.samples_per_pixel; ++s) {
      const Sight& sight = *samples++;
      radiance += sight.shine;
      solid += sight.kind == Sight::Kind::solid;
      if (sight.kind != Sight::Kind::receiver) continue;
      radiance += sight.albedo * next->irradiance / kPi;
      irradiance += next->irradiance;
      variance += next->deviation * next->deviation;
      ++next, ++count;
    }
    const auto of_samples = 1.0f / static_cast<float>(sights.samples_per_pixel);
    const auto of_receivers = 1.0f / static_cast<float>(std::max(1, count));
    picture->radiance[pixel] = radiance * of_samples;
    picture->irradiance[pixel] = irradiance * of_receivers;
    picture->deviation[pixel] = glm::sqrt(variance) * of_receivers;
    picture->receiver_share[pixel] = static_cast<float>(count) * of_samples;
    picture->in_solid[pixel] = solid == sights.samples_per_pixel;
  }
  return {received.size(),
          static_cast<uint64_t>(std::count_if(received.begin(), received.end(), [](const auto& a) { return !a.is_lit; }))};
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

LitPicture lightPicture(const Sights& sights, const Lighting& lighting, int thread_count) {
  LitPicture picture;
  picture.method = lighting.name;
  picture.width = sights.width;
  picture.height = sights.height;
  const size_t pixels = static_cast<size_t>(sights.width) * sights.height;
  picture.radiance.resize(pixels);
  picture.irradiance.resize(pixels);
  picture.deviation.resize(pixels);
  picture.receiver_share.resize(pixels);
  picture.in_solid.resize(pixels);
  std::vector<RowCount> counts(sights.height);
  parallelFor(sights.height, thread_count, [&](uint64_t row, int) { counts[row] = lightRow(sights, lighting, row, &picture); });
  RowCount all;
  for (const RowCount& count : counts) all.receivers += count.receivers, all.unlit += count.unlit;
  if (all.receivers > 0) picture.unlit_share = static_cast<double>(all.unlit) / static_cast<double>(all.receivers);
  return picture;
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
