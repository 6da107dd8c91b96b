#include "light/methods/ddgi.h"

#include <limits>
#include <numbers>

#include "light/directions.h"
#include "runtime_eval/numbers/half.h"
#include "runtime_eval/numbers/random.h"
#include "scene/model/surface_look.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr float kTwoPi = 2.0f * std::numbers::pi_v<float>;
// RTXGI's cornell.ini, and what its shaders say
constexpr double kDdgiNormalBiasM = 0.02;
constexpr float kGamma = 5.0f, kDepthExponent = 50.0f;
constexpr float kBackfaceDepth = 0.2f;     // of the distance to a back face, so that probes in solid are hardly seen
constexpr float kDepthReach = 1.5f;        // of a cell's diagonal
constexpr float kMaxBackfaceShare = 0.1f;  // else nothing is blended into the probe
constexpr float kLeastVisibility = 0.05f, kLeastProbeWeight = 1e-6f, kCrushedBelow = 0.2f, kLeastAxisWeight = 1e-3f;
// relocation
constexpr int kRelocationRays = 32, kRelocationRounds = 64;
constexpr float kRelocationBackfaceShare = 0.25f, kLeastFrontDistance = 1.0f / 3.0f;  // of the spacing: .1 m at .3 m
constexpr double kMostOffset = 0.45;                                                  // of the spacing

float roundedToHalf(float value) {
  Half half;
  return halfFromFloat(value, &half) ? floatFromHalf(half) : std::copysign(kMaxHalf, value);
}

// A probe's ray: how far the first face is, and whether it meets a back.
struct ProbeRay {
  glm::vec3 direction;
  float distance;  // infinite where the ray leaves the scene, or meets its sky
  bool is_back;
};

ProbeRay castRay(const LightTransport& transport, const glm::dvec3& from, const glm::vec3& direction, SheetBacks backs) {
  const LightHit hit = transport.rays().lightHit(glm::vec3(from), direction);
  if (hit.kind != LightHit::Kind::surface) return {direction, std::numeric_limits<float>::infinity(), false};
  const bool has_back = backs == SheetBacks::as_wound || !materialOf(transport.scene(), hit.triangle).double_sided;
  return {direction, hit.distance, !hit.is_front && has_back};
}

std::vector<ProbeRay> castRays(const LightTransport& transport, const glm::dvec3& from, int count, SheetBacks backs,
                               uint64_t seed) {
  const Lattice lattice(seed);
  std::vector<ProbeRay> result;
  result.reserve(count);
  for (int i = 0; i < count; ++i) {
    const auto [u, v] = lattice.point(i, count);
    result.push_back(castRay(transport, from, sphereDirection(u, v), backs));
  }
  return result;
}

float backfaceShare(const std::vector<ProbeRay>& rays) {
  const auto backs = std::count_if(rays.begin(), rays.end(), [](const ProbeRay& ray) { return ray.is_back; });
  return static_cast<float>(backs) / static_cast<float>(rays.size());
}

// One round of ProbeRelocationCS: the offset that the probe would have next; none within its reach: the same again.
glm::dvec3 movedOffset(const std::vector<ProbeRay>& rays, const glm::dvec3& offset, float spacing_m) {
  const ProbeRay *closest_back = nullptr, *closest_front = nullptr, *farthest_front = nullptr;
  for (const ProbeRay& ray : rays) {
    const ProbeRay*& closest = ray.is_back ? closest_back : closest_front;
    if (closest == nullptr || ray.distance < closest->distance) closest = &ray;
    if (!ray.is_back && (farthest_front == nullptr || ray.distance > farthest_front->distance)) farthest_front = &ray;
  }
  const float least_m = kLeastFrontDistance * spacing_m;
  // out of solid past the nearest back face; else away from a near front face; else back towards the lattice
  glm::dvec3 moved = offset;
  if (closest_back != nullptr && backfaceShare(rays) > kRelocationBackfaceShare) {
    moved += glm::dvec3(closest_back->direction) * double{closest_back->distance + 0.5f * least_m};
  } else if (closest_front != nullptr && closest_front->distance < least_m) {
    // not where the way to the farthest face leads closer to the nearest one
    if (glm::dot(closest_front->direction, farthest_front->direction) <= 0.0f)
      moved += glm::dvec3(farthest_front->direction) * double{std::min(farthest_front->distance, least_m)};
  } else if (closest_front != nullptr && glm::length(offset) > 0.0) {
    const double back = std::min<double>(closest_front->distance - least_m, glm::length(offset));
    moved -= glm::normalize(offset) * back;
  }
  return glm::length(moved) < kMostOffset * spacing_m ? moved : offset;
}

glm::dvec3 relocated(const LightTransport& transport, const glm::dvec3& position_m, float spacing_m, SheetBacks backs,
                     uint64_t seed) {
  glm::dvec3 offset(0.0);
  for (int round = 0; round < kRelocationRounds; ++round) {
    const std::vector<ProbeRay> rays = castRays(transport, position_m + offset, kRelocationRays, backs, seed);
    const glm::dvec3 moved = movedOffset(rays, offset, spacing_m);
    if (glm::length(moved - offset) < 1e-6 * spacing_m) break;
    offset = moved;
  }
  return position_m + offset;
}

void blendIrradiance(const std::vector<ArrivingLight>& arriving, DdgiProbe* probe) {
  for (int texel = 0; texel < probe->irradiance.kTexelCount; ++texel) {
    const glm::vec3 direction = probe->irradiance.direction(texel);
    glm::vec3 sum(0.0f);
    for (const ArrivingLight& light : arriving) sum += light.flux * std::max(0.0f, glm::dot(direction, light.direction));
    probe->irradiance.texels[texel] = glm::pow(sum / kTwoPi, glm::vec3(1.0f / kGamma));
  }
}

void blendDepth(const std::vector<ProbeRay>& rays, float spacing_m, DdgiProbe* probe) {
  const float reach_m = kDepthReach * spacing_m * std::sqrt(3.0f);
  for (int texel = 0; texel < probe->depth.kTexelCount; ++texel) {
    const glm::vec3 direction = probe->depth.direction(texel);
    glm::vec2 sum(0.0f);
    float weights = 0.0f;
    for (const ProbeRay& ray : rays) {
      const float cosine = glm::dot(direction, ray.direction);
      if (cosine <= 0.0f) continue;
      const float weight = std::pow(cosine, kDepthExponent);
      const float depth = std::min(ray.is_back ? kBackfaceDepth * ray.distance : ray.distance, reach_m);
      sum += weight * glm::vec2(depth, depth * depth);
      weights += weight;
    }
    probe->depth.texels[texel] = sum / std::max(weights, 1e-9f * static_cast<float>(rays.size()));
  }
}

}  // namespace

bool hasSheets(const Scene& scene) {
  // probes' rays pass through transmissive surfaces
  return std::any_of(scene.triangle_material.begin(), scene.triangle_material.end(), [&](uint32_t idx) {
    return scene.materials[idx].double_sided && scene.materials[idx].transmissive == Transmissive::none;
  });
}

DdgiMaps makeDdgiMaps(const ProbeSet& probes, const LightTransport& transport, const DdgiMapsOptions& options) {
  DdgiMaps maps;
  maps.probes.resize(probes.count());
  const double start = processorSeconds();
  parallelFor(probes.count(), options.thread_count, [&](uint64_t p, int) {
    DdgiProbe& probe = maps.probes[p];
    const uint64_t seed = mixSeed(options.seed, p);
    probe.position_m = probes.position_m[p];
    if (options.relocates) probe.position_m = relocated(transport, probe.position_m, probes.spacing_m[p], options.backs, seed);
    const std::vector<ProbeRay> rays = castRays(transport, probe.position_m, options.gather.rays, options.backs, seed);
    probe.is_active = backfaceShare(rays) <= kMaxBackfaceShare;
    if (!probe.is_active) return;
    blendDepth(rays, probes.spacing_m[p], &probe);
    blendIrradiance(transport.arriving(probe.position_m, options.gather, seed), &probe);
  });
  maps.bake_s = processorSeconds() - start;
  return maps;
}

DdgiMaps asShipped(DdgiMaps maps) {
  float brightest = 0.0f;
  for (const DdgiProbe& probe : maps.probes) {
    for (const glm::vec3& texel : probe.irradiance.texels) brightest = std::max({brightest, texel.r, texel.g, texel.b});
  }
  // one scale for the level: 10 bits a channel of irradiance, float16 of depths
  if (brightest > 0.0f) maps.scale = std::pow(brightest, kGamma);
  for (DdgiProbe& probe : maps.probes) {
    for (glm::vec3& texel : probe.irradiance.texels)
      texel = brightest > 0.0f ? glm::round(texel / brightest * 1023.0f) / 1023.0f : texel;
    for (glm::vec2& texel : probe.depth.texels) texel = {roundedToHalf(texel.x), roundedToHalf(texel.y)};
  }
  return maps;
}

float Ddgi::chebyshev(const DdgiProbe& probe, const glm::dvec3& biased_m) const {
  const glm::vec3 way(biased_m - probe.position_m);
  const float distance = glm::length(way);
  if (!(distance > 0.0f)) return 1.0f;
  const glm::vec2 moments = probe.depth.at(way / distance);
  if (distance <= moments.x) return 1.0f;
  // Chebyshev's bound on the chance that nothing stands between, cubed as RTXGI does
  const float variance = std::fabs(moments.x * moments.x - moments.y);
  const float beyond = distance - moments.x;
  const float bound = variance / (variance + beyond * beyond);
  return bound * bound * bound;
}

float Ddgi::probeWeight(const DdgiProbe& probe, const glm::dvec3& position_m, const glm::dvec3& biased_m,
                        const glm::vec3& normal) const {
  const glm::vec3 to_probe(probe.position_m - position_m);
  const float distance = glm::length(to_probe);
  // RTXGI's weight: the wrapped normal, visibility, and a cubic that crushes what is small
  const float wrap = distance > 0.0f ? (glm::dot(to_probe / distance, normal) + 1.0f) * 0.5f : 1.0f;
  float weight = wrap * wrap + 0.2f;
  weight *= std::max(kLeastVisibility, chebyshev(probe, biased_m));
  weight = std::max(kLeastProbeWeight, weight);
  if (weight < kCrushedBelow) weight *= weight * weight / (kCrushedBelow * kCrushedBelow);
  return weight;
}

ProbeBlend Ddgi::blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
  ProbeBlend blend;
  const glm::dvec3 biased = position_m + kDdgiNormalBiasM * glm::dvec3(normal);
  ProbesAround around;
  if (!probes_.tree.lookUp({biased.x, biased.y, biased.z}, &around) &&
      !probes_.tree.lookUp({position_m.x, position_m.y, position_m.z}, &around)) {
    blend.reach = Reach::outside;
    return blend;
  }
  const glm::dvec3 alpha = placeInCell(probes_.tree, around.cell, biased);
  for (int c = 0; c < 8; ++c) {
    const uint32_t p = around.corners[c].probe;
    const DdgiProbe& probe = maps_.probes[p];
    if (!probe.is_active) continue;
    float trilinear = 1.0f;
    for (int axis = 0; axis < 3; ++axis)
      trilinear *= std::max(kLeastAxisWeight, static_cast<float>(c >> axis & 1 ? alpha[axis] : 1.0 - alpha[axis]));
    blend.add(p, trilinear * probeWeight(probe, position_m, biased, normal));
  }
  blend.finish(Reach::lit);
  return blend;
}

LightAnswer Ddgi::irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
  const ProbeBlend blend = blendAt(position_m, normal);
  glm::vec3 roots(0.0f);
  for (int i = 0; i < blend.count; ++i) {
    const glm::vec3 stored = maps_.probes[blend.probe[i]].irradiance.at(normal);
    // stored to the power 1 / 5, blended as square roots, as RTXGI does
    roots += blend.weight[i] * glm::pow(stored, glm::vec3(0.5f * kGamma));
  }
  return {roots * roots * kTwoPi * maps_.scale, blend.reach};
}

}  // namespace nlg
