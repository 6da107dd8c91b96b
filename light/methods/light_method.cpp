#include "light/methods/light_method.h"

#include <bit>

#include "light/air.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr size_t kAskedAtOnce = 512;  // receivers: what is near together is looked up together

// Noise of neighbouring pixels must not be alike, and a receiver's must not depend on where in a picture it stands.
uint64_t seedOf(const Receiver& receiver, uint64_t seed) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  const glm::dvec3& p = receiver.position_m;
  const glm::dvec3 n(receiver.normal);
  return mixSeed(mixSeed(bits(p.x), bits(p.y), bits(p.z), seed), bits(n.x), bits(n.y), bits(n.z));
}

}  // namespace

LightAnswer answerAt(const LightAt& light_at, const Receiver& receiver) {
  LightAnswer answer;
  light_at({&receiver, 1}, &answer);
  return answer;
}

std::vector<LightAnswer> answersAt(const LightAt& light_at, const std::vector<Receiver>& receivers, int thread_count) {
  std::vector<LightAnswer> answers(receivers.size());
  parallelForBlocks(receivers.size(), kAskedAtOnce, thread_count, [&](uint64_t first, uint64_t end, int) {
    light_at({&receivers[first], end - first}, &answers[first]);
  });
  return answers;
}

LightAt trueLight(const LightTransport& transport, const GatherOptions& options, uint64_t seed) {
  return [&transport, options, seed](std::span<const Receiver> receivers, LightAnswer* answers) {
    for (const Receiver& at : receivers) {
      const GatheredIrradiance gathered = transport.gatherIrradiance(at.position_m, at.normal, options, seedOf(at, seed));
      *answers++ = {gathered.irradiance, Reach::lit, gathered.deviation};
    }
  };
}

void ProbeBlend::finish(Reach when_lit) {
  sum = 0.0f;
  for (int i = 0; i < count; ++i) sum += weight[i];
  for (int i = 0; i < count; ++i) weight[i] /= sum;
  reach = count > 0 ? when_lit : Reach::unlit;
}

ProbeWeights Weighting::weightsAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
  const ProbeBlend blend = blendAt(position_m, normal);
  ProbeWeights weights;
  weights.count = blend.count;
  for (int i = 0; i < blend.count; ++i) {
    weights.probe[i] = blend.probe[i];
    weights.weight[i] = blend.sum * blend.weight[i];
  }
  return weights;
}

LightAt blendedLight(const Weighting& weighting, const std::vector<LightSh>& light) {
  return [&](std::span<const Receiver> receivers, LightAnswer* answers) {
    for (const Receiver& at : receivers) {
      const ProbeBlend blend = weighting.blendAt(at.position_m, at.normal);
      LightSh sum{};
      for (int i = 0; i < blend.count; ++i) {
        for (int k = 0; k < kShCount; ++k) sum[k] += blend.weight[i] * light[blend.probe[i]][k];
      }
      *answers++ = {flooredIrradiance(sum, at.normal), blend.reach};
    }
  };
}

ProbeSet makeProbeSet(const ProbeTree& tree, const LightTransport& transport, const ProbeSetOptions& options) {
  ProbeSet set;
  set.tree = tree;
  const size_t count = tree.probeCount();
  set.spacing_m.resize(count);
  set.is_in_air.resize(count);
  set.light.resize(count);
  for (size_t p = 0; p < count; ++p) {
    const PositionM at = tree.probePosition(p);
    set.position_m.emplace_back(at[0], at[1], at[2]);
    set.spacing_m[p] = tree.probeSpacing(p);
  }
  const double start = processorSeconds();
  parallelFor(count, options.thread_count, [&](uint64_t p, int) {
    set.is_in_air[p] = isInAir(transport.rays(), set.position_m[p]);
    set.light[p] = transport.gather(set.position_m[p], options.gather, mixSeed(options.seed, p)).light;
  });
  set.gather_s = processorSeconds() - start;
  for (const uint8_t in_air : set.is_in_air) set.air_count += in_air;
  return set;
}

glm::dvec3 placeInCell(const ProbeTree& tree, const ProbeCell& cell, const glm::dvec3& position_m) {
  glm::dvec3 share;
  for (int axis = 0; axis < 3; ++axis) {
    const double units = (position_m[axis] - tree.frame().first_m[axis]) / tree.frame().spacing_m;
    share[axis] = glm::clamp((units - cell.low[axis]) / cell.side, 0.0, 1.0);
  }
  return share;
}

}  // namespace nlg
