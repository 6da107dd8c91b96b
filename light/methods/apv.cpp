#include "light/methods/apv.h"

#include <algorithm>

#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

// The defaults of Unity 6.
constexpr double kApvNormalBiasM = 0.05;
constexpr double kSearchShare = 0.2, kOutOfGeometryM = 0.01;  // of the spacing: how far a virtual offset looks
constexpr double kDilationM = 1.0;                            // at least a spacing, or nothing would be reached
constexpr float kInvalidShare = 0.25f;                        // of back faces
constexpr int kValidityRays = 64;

// Out of the nearest back face among 26 directions, if there is one.
glm::dvec3 virtualOffset(const RayScene& rays, const glm::dvec3& from, float spacing_m) {
  glm::dvec3 offset(0.0);
  double nearest = kSearchShare * spacing_m;
  for (int i = 0; i < 27; ++i) {
    const glm::ivec3 way(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (way == glm::ivec3(0)) continue;
    const glm::vec3 direction = glm::normalize(glm::vec3(way));
    const LightHit hit = rays.lightHit(glm::vec3(from), direction);
    if (hit.kind != LightHit::Kind::surface || hit.is_front || hit.distance >= nearest) continue;
    nearest = hit.distance;
    offset = glm::dvec3(direction) * (nearest + kOutOfGeometryM);
  }
  return offset;
}

bool isValid(const RayScene& rays, const glm::dvec3& at, uint64_t seed) {
  const Lattice lattice(seed);
  int backs = 0;
  for (int i = 0; i < kValidityRays; ++i) {
    const auto [u, v] = lattice.point(i, kValidityRays);
    const LightHit hit = rays.lightHit(glm::vec3(at), sphereDirection(u, v));
    backs += hit.kind == LightHit::Kind::surface && !hit.is_front;
  }
  return static_cast<float>(backs) <= kInvalidShare * kValidityRays;
}

// Light of valid probes within reach, by the inverse square of their distance; its own where there is none.
LightSh dilated(const ProbeSet& probes, const ApvProbes& baked, size_t p) {
  const double reach_m = std::max<double>(kDilationM, probes.spacing_m[p]) * 1.001;
  LightSh sum{};
  float weights = 0.0f;
  // the neighbours are the corners of the cells around: looked up a little off the probe in all eight directions
  std::vector<uint32_t> seen;
  for (int side = 0; side < 8; ++side) {
    const glm::dvec3 off =
        1e-3 * probes.tree.frame().spacing_m * glm::dvec3(side & 1 ? 1 : -1, side & 2 ? 1 : -1, side & 4 ? 1 : -1);
    const glm::dvec3 at = probes.position_m[p] + off;
    ProbesAround around;
    if (!probes.tree.lookUp({at.x, at.y, at.z}, &around)) continue;
    for (const ProbeAround& corner : around.corners) {
      const double distance = glm::distance(probes.position_m[p], probes.position_m[corner.probe]);
      if (!baked.is_valid[corner.probe] || distance > reach_m) continue;
      if (std::find(seen.begin(), seen.end(), corner.probe) != seen.end()) continue;
      seen.push_back(corner.probe);
      const auto weight = static_cast<float>(1.0 / (distance * distance));
      for (int k = 0; k < kShCount; ++k) sum[k] += weight * baked.light[corner.probe][k];
      weights += weight;
    }
  }
  if (!(weights > 0.0f)) return baked.light[p];
  for (glm::vec3& value : sum) value /= weights;
  return sum;
}

}  // namespace

ApvProbes bakeApvProbes(const ProbeSet& probes, const LightTransport& transport, const ProbeSetOptions& options) {
  ApvProbes baked;
  baked.is_valid.resize(probes.count());
  baked.light.resize(probes.count());
  const double start = processorSeconds();
  parallelFor(probes.count(), options.thread_count, [&](uint64_t p, int) {
    const uint64_t seed = mixSeed(options.seed, p);
    const glm::dvec3 capture = probes.position_m[p] + virtualOffset(transport.rays(), probes.position_m[p], probes.spacing_m[p]);
    baked.is_valid[p] = isValid(transport.rays(), capture, seed);
    baked.light[p] = transport.gather(capture, options.gather, seed).light;
  });
  std::vector<LightSh> light = baked.light;
  for (size_t p = 0; p < probes.count(); ++p) {
    if (!baked.is_valid[p]) light[p] = dilated(probes, baked, p);
  }
  baked.light = std::move(light);
  baked.bake_s = processorSeconds() - start;
  return baked;
}

ProbeBlend Apv::blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
  ProbeBlend valid, all;
  ProbesAround around;
  // biased along the normal as in Unity, unless that leaves the grid
  const glm::dvec3 biased = position_m + kApvNormalBiasM * glm::dvec3(normal);
  if (!probes_.tree.lookUp({biased.x, biased.y, biased.z}, &around) &&
      !probes_.tree.lookUp({position_m.x, position_m.y, position_m.z}, &around)) {
    valid.reach = Reach::outside;
    return valid;
  }
  for (const ProbeAround& corner : around.corners) {
    const float weight = tent(corner.local) * corner.tent_ratio;
    all.add(corner.probe, weight);
    if (baked_.is_valid[corner.probe]) valid.add(corner.probe, weight);
  }
  const bool has_valid = valid.count > 0;
  ProbeBlend& blend = has_valid ? valid : all;
  blend.finish(has_valid ? Reach::lit : Reach::fallback);
  return blend;
}

}  // namespace nlg
