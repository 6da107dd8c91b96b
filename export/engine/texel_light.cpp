#include "export/engine/texel_light.h"

#include <algorithm>
#include <cmath>

#include "light/air.h"
#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kTexelStream = 0x746578656c, kTruthStream = 0x7472757468;

std::vector<glm::dvec3> centresOf(const LightBox& box, const glm::dvec3& origin_m) {
  std::vector<glm::dvec3> centres;
  for (size_t texel = 0; texel < box.texelCount(); ++texel) {
    const PositionM at = box.texelCentre(texel);
    centres.push_back(glm::dvec3(at[0], at[1], at[2]) - origin_m);
  }
  return centres;
}

}  // namespace

PositionM inWorld(const Scene& scene, const glm::dvec3& position_m) {
  const glm::dvec3 world = position_m + scene.origin_m;
  return {world.x, world.y, world.z};
}

std::array<double, 3> TexelLookUp::texelM() const {
  std::array<double, 3> texel_m;
  for (size_t axis = 0; axis < 3; ++axis) texel_m[axis] = (box.high_m[axis] - box.low_m[axis]) / box.texel_count[axis];
  return texel_m;
}

void TexelLookUp::weightsAt(const PositionM& position_m, const float* normal_3, ProbeWeights* weights) const {
  const std::array<double, 3> texel_m = texelM();
  std::array<int64_t, 3> low;
  std::array<double, 3> share;
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto last = static_cast<double>(box.texel_count[axis] - 1);
    double at = (position_m[axis] - box.low_m[axis]) / texel_m[axis] - 0.5 + bias * normal_3[axis];
    if (is_valid.empty()) at = std::clamp(at, 0.0, last);
    const double floor = std::floor(at);
    low[axis] = static_cast<int64_t>(std::clamp(floor, 0.0, last));
    share[axis] = at - floor;
  }
  weights->count = 0;
  float sum = 0.0f;
  for (unsigned corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    std::array<size_t, 3> texel;
    bool is_inside = true;
    for (size_t axis = 0; axis < 3; ++axis) {
      const int64_t at = low[axis] + (corner >> axis & 1);
      weight *= (corner >> axis & 1) != 0 ? share[axis] : 1.0 - share[axis];
      is_inside = is_inside && at < static_cast<int64_t>(box.texel_count[axis]);
      texel[axis] = static_cast<size_t>(at);
    }
    if (!is_inside || !(weight > 0.0)) continue;
    const size_t index = (texel[2] * box.texel_count[1] + texel[1]) * box.texel_count[0] + texel[0];
    if (!is_valid.empty() && !is_valid[index]) continue;
    weights->probe[weights->count] = static_cast<uint32_t>(index);
    weights->weight[weights->count++] = static_cast<float>(weight);
    sum += static_cast<float>(weight);
  }
  if (sum >= kWhole) return;
  for (int i = 0; i < weights->count; ++i) weights->weight[i] /= sum;
}

LightVolume placeTexels(const MeasuredScene& scene, const LightBox& box) {
  const std::vector<glm::dvec3> centres = centresOf(box, scene.transport.scene().origin_m);
  std::vector<LightSh> light(centres.size());
  std::vector<uint8_t> is_in_air(centres.size());
  parallelFor(centres.size(), scene.thread_count, [&](uint64_t t, int) {
    is_in_air[t] = isInAir(scene.transport.rays(), centres[t]);
    if (!is_in_air[t]) return;
    light[t] = scene.transport.gather(centres[t], scene.options.probe, mixSeed(scene.options.seed, kTexelStream, t)).light;
  });
  return filledVolume(box, floatsOf(light), is_in_air);
}

std::vector<LightSh> lightOf(const LightVolume& volume) {
  std::vector<LightSh> light(volume.box.texelCount());
  for (size_t i = 0; i < volume.light.size(); ++i)
    light[i / kShFloats][i % kShFloats / kShChannels][static_cast<int>(i % kShChannels)] = volume.light[i];
  return light;
}

std::vector<LightSh> solveTexels(const MeasuredScene& scene, const TexelLookUp& look_up,
                                 const std::vector<LightSh>& place_light) {
  // one normal a place, drawn by the place itself
  const WeightsAt weights_at = [&](const glm::dvec3& position_m, ProbeWeights* weights) {
    look_up.weightsAt(inWorld(scene.transport.scene(), position_m), &randomNormal(position_m)[0], weights);
  };
  TexelLookUp all = look_up;
  all.is_valid.clear();
  const std::array<double, 3> texel_m = look_up.texelM();
  const LitPoints texels = {centresOf(look_up.box, scene.transport.scene().origin_m),
                            [&](const glm::dvec3& position_m, ProbeWeights* weights) {
                              all.weightsAt(inWorld(scene.transport.scene(), position_m), &randomNormal(position_m)[0], weights);
                            },
                            *std::min_element(texel_m.begin(), texel_m.end())};
  return lightProbes(scene.transport, texels, scene.places, place_light, weights_at, scene.options, scene.thread_count).light;
}

TexelJudge::TexelJudge(const MeasuredScene& scene, const ExtentBox& extent, int places, uint64_t seed)
    : scene_(scene), seed_(seed) {
  LightPlaceOptions options;
  options.air = options.surface = static_cast<uint64_t>(places);
  options.walks = options.edges = 0;
  options.seed = seed;
  places_ = drawLightPlaces(scene.transport.scene(), scene.transport.rays(), extent, options);
}

void TexelJudge::trace(int rays) {
  GatherOptions gather{rays};
  gather.direct = scene_.options.place.direct;
  truth_ = lightTruth(places_, scene_.transport, {gather, mixSeed(seed_, kTruthStream), scene_.thread_count});
}

void TexelJudge::take(
    const std::function<bool(const glm::dvec3& position_m, const float* normal_3, glm::vec3* irradiance)>& truth) {
  std::vector<LightPlace> known;
  truth_ = {};
  for (const LightPlace& place : places_.places) {
    GatheredIrradiance at;
    if (!truth(place.position_m, &place.normal[0], &at.irradiance)) continue;
    known.push_back(place);
    truth_.at.push_back(at);
  }
  places_.places = std::move(known);
}

LightFigures TexelJudge::errorOf(const EngineIrradiance& shown) const {
  std::vector<LightAnswer> answers(places_.places.size());
  parallelFor(answers.size(), scene_.thread_count, [&](uint64_t i, int) {
    const LightPlace& place = places_.places[i];
    const std::array<float, kShChannels> rgb = shown(inWorld(scene_.transport.scene(), place.position_m), &place.normal[0]);
    answers[i] = {{rgb[0], rgb[1], rgb[2]}, Reach::lit};
  });
  return lightFigures(places_, truth_, answers);
}

}  // namespace nlg
