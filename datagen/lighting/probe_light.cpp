#include "datagen/lighting/probe_light.h"

#include <algorithm>
#include <atomic>

#include "datagen/lighting/air.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kPlaceStream = 0x706c6163, kProbeStream = 0x70726f62;
constexpr uint64_t kBlockPlaces = 64;
// Of the tent in the mean that a probe begins with: too little to count where its function has weight anywhere.
constexpr float kTentShare = 1e-4f;

float luminanceOf(const LightSh& light) {
  const glm::vec3& mean = light[0];
  return std::max(0.0f, 0.2126f * mean.r + 0.7152f * mean.g + 0.0722f * mean.b);
}

void add(LightSh* sum, float weight, const LightSh& light) {
  for (int k = 0; k < kShCount; ++k) (*sum)[k] += weight * light[k];
}

// Light under weights that were never normalised: every probe's own mean.
struct Means {
  std::vector<LightSh> light;
  std::vector<float> weight;
  std::vector<uint8_t> is_read;

  Means(const ProbeTree& tree, const std::vector<glm::dvec3>& places, const std::vector<ProbeWeights>& weights,
        const std::vector<LightSh>& place_light)
      : light(tree.probeCount()), weight(tree.probeCount(), 0.0f), is_read(tree.probeCount(), 0) {
    const auto addTo = [&](uint32_t probe, float share, const LightSh& of_place) {
      add(&light[probe], share, of_place);
      weight[probe] += share;
    };
    for (size_t i = 0; i < places.size(); ++i) {
      for (int j = 0; j < weights[i].count; ++j) {
        addTo(weights[i].probe[j], weights[i].weight[j], place_light[i]);
        is_read[weights[i].probe[j]] = 1;
      }
      ProbesAround around;
      if (!tree.lookUp({places[i].x, places[i].y, places[i].z}, &around)) continue;
      for (const ProbeAround& corner : around.corners)
        addTo(corner.probe, kTentShare * tent(corner.local) * corner.tent_ratio, place_light[i]);
    }
    for (size_t p = 0; p < light.size(); ++p) {
      for (glm::vec3& value : light[p]) value /= std::max(weight[p], 1e-12f);
    }
  }
};

std::vector<LightSample> samplesOf(const std::vector<ProbeWeights>& weights, const std::vector<LightSh>& place_light,
                                   double dark_share) {
  double mean = 0.0;
  for (const LightSh& light : place_light) mean += luminanceOf(light) / static_cast<double>(place_light.size());
  const auto floor = static_cast<float>(std::max(1e-12, dark_share * mean));
  std::vector<LightSample> samples;
  for (size_t i = 0; i < weights.size(); ++i) {
    ProbeWeights normalised = weights[i];
    if (!normaliseWeights(&normalised)) continue;
    LightSample sample;
    sample.count = normalised.count;
    std::copy_n(normalised.probe, normalised.count, sample.probe.begin());
    std::copy_n(normalised.weight, normalised.count, sample.weight.begin());
    // between absolute and relative error: an eye sees shares, but noise rules where there is no light
    sample.importance = static_cast<float>(mean) / (luminanceOf(place_light[i]) + floor);
    sample.light = place_light[i];
    samples.push_back(sample);
  }
  return samples;
}

ProbeLight solved(const std::vector<LightSample>& samples, Means means, double pull_share) {
  std::vector<float> diagonal(means.light.size(), 0.0f);
  double total = 0.0;
  for (const LightSample& sample : samples) {
    for (int j = 0; j < sample.count; ++j) {
      const float curvature = sample.importance * sample.weight[j] * sample.weight[j];
      diagonal[sample.probe[j]] += curvature;
      total += curvature;
    }
  }
  // probes that are hardly read follow their mean
  const double least = 1e-3 * total / std::max<double>(1.0, static_cast<double>(diagonal.size())) + 1e-12;
  for (float& pull : diagonal) pull = static_cast<float>(pull_share * pull + least);
  LightSolution solution = solveLight(samples, means.light, diagonal);
  return {std::move(solution.light), solution.iterations, 0};
}

}  // namespace

LightWay lightWayFromName(const std::string& name) {
  if (name == "point") return LightWay::point;
  if (name == "integrated") return LightWay::integrated;
  if (name == "solved") return LightWay::solved;
  throw UsageError("light", "solved, integrated or point", "'" + name + "'");
}

WeightsAt weightsOf(const LightGrid& grid, const glm::dvec3& origin_m) {
  return [&grid, origin_m](const glm::dvec3& position_m, ProbeWeights* weights) {
    const glm::dvec3 world = position_m + origin_m;
    weights->count = 0;
    lookUpWeights(grid, {world.x, world.y, world.z}, weights);
  };
}

std::vector<LightSh> measureLight(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                  const GatherOptions& options, uint64_t seed, int thread_count) {
  std::vector<LightSh> light(places.size());
  Progress progress("places lit", static_cast<int64_t>(places.size()));
  std::atomic<int64_t> done{0};
  parallelFor((places.size() + kBlockPlaces - 1) / kBlockPlaces, thread_count, [&](uint64_t block, int thread) {
    const uint64_t end = std::min<uint64_t>((block + 1) * kBlockPlaces, places.size());
    for (uint64_t i = block * kBlockPlaces; i < end; ++i)
      light[i] = transport.gather(places[i], options, mixSeed(seed, kPlaceStream, i)).light;
    done += static_cast<int64_t>(kBlockPlaces);
    if (thread == 0) progress.update(std::min<int64_t>(done, static_cast<int64_t>(places.size())));
  });
  return light;
}

ProbeLight lightProbes(const LightTransport& transport, const ProbeTree& tree, const std::vector<glm::dvec3>& places,
                       const std::vector<LightSh>& place_light, const WeightsAt& weights_at, const ProbeLightOptions& options,
                       int thread_count) {
  NLG_CHECK(places.size(), ==, place_light.size());
  std::vector<ProbeWeights> weights(places.size());
  parallelFor((places.size() + kBlockPlaces - 1) / kBlockPlaces, thread_count, [&](uint64_t block, int) {
    const uint64_t end = std::min<uint64_t>((block + 1) * kBlockPlaces, places.size());
    for (uint64_t i = block * kBlockPlaces; i < end; ++i) weights_at(places[i], &weights[i]);
  });
  Means means(tree, places, weights, place_light);
  const auto unread = static_cast<uint64_t>(std::count(means.is_read.begin(), means.is_read.end(), 0));
  ProbeLight result;
  if (options.way == LightWay::solved) {
    result = solved(samplesOf(weights, place_light, options.dark_share), std::move(means), options.pull);
  } else {
    result.light = std::move(means.light);
  }
  if (options.way == LightWay::point) {
    parallelFor(tree.probeCount(), thread_count, [&](uint64_t p, int) {
      const auto [x, y, z] = tree.probePosition(p);
      if (!isInAir(transport.rays(), {x, y, z})) return;
      result.light[p] = transport.gather({x, y, z}, options.probe, mixSeed(options.seed, kProbeStream, p)).light;
    });
  }
  result.unread = unread;
  return result;
}

}  // namespace nlg
