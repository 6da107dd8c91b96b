#include "nlg/look_up.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/evaluate.h"

#include <algorithm>

namespace nlg {

void weightsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights) {
  constexpr float kStretch = 1.0f / (1.0f - kResidue);
  static_assert((1.0f - kResidue) * kStretch == 1.0f, "bare tents would not keep all");
  weights->count = 0;
  float sum = 0.0f, believed = 0.0f;
  for (const ProbeAround& corner : around.corners) {
    const uint32_t function = grid.probe_function[corner.probe];
    if (function == kNoWeight) continue;
    const float bare = tent(corner.local);
    // v: 1 of a bare tent, of a code straight from its brick
    float share = 1.0f;
    if (function != kFreeSpace) {
      const Representation& representation = grid.representations[grid.function_representation[function]];
      share = representation.isCode() ? evaluateQuads(representation.resolution, corner.local, grid.function_brick[function].step,
                                                      grid.functionQuads(function))
                                      : evaluateTentShare(representation, corner.local, bare, grid.functionTheta(function));
    }
    // w = t ρ (v - r) / (1 - r) (docs/theory/probes.md)
    const float above = share - kResidue;
    const float weight = bare * corner.tent_ratio * (above * kStretch);
    if (!(weight >= kLeastWeight)) continue;
    weights->probe[weights->count] = corner.probe;
    weights->weight[weights->count++] = weight;
    sum += weight;
    believed += weight * above;
  }
  // 1 where the mean of v is at least twice the residue (docs/theory/probes.md)
  weights->certainty = sum > 0.0f ? std::min(1.0f, believed / (kResidue * sum)) : 0.0f;
}

bool lookUpWeights(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights) {
  ProbesAround around;
  if (!grid.tree.lookUp(position_m, &around)) return false;
  weightsAround(grid, around, weights);
  return true;
}

bool normaliseWeights(ProbeWeights* weights) {
  if (weights->count == 0) return false;
  float sum = 0.0f;
  for (int i = 0; i < weights->count; ++i) sum += weights->weight[i];
  const float scale = weights->certainty / sum;
  for (int i = 0; i < weights->count; ++i) weights->weight[i] *= scale;
  return true;
}

namespace {

// Of a probe's light over all directions, in any unit.
float luminanceOf(const float* light_9x3) {
  return std::max(0.0f, 0.2126f * light_9x3[0] + 0.7152f * light_9x3[1] + 0.0722f * light_9x3[2]);
}

// What the certainty lacks of 1 goes to the tents of probes that have functions, over the square of the light that they hold. No
// tent is left out for being small: a dark probe's counts ten thousand times.
// shares   that add up to the certainty, in the order of corners, as they are afterwards
void addDarkest(const LightGrid& grid, const ProbesAround& around, ProbeWeights* shares) {
  constexpr float kNoLight = 1e-20f;  // keeps quotients finite where there is none
  std::array<float, 8> weight{}, luminance{};
  float tents = 0.0f, light = 0.0f;
  for (size_t c = 0; c < 8; ++c) {
    const ProbeAround& corner = around.corners[c];
    if (grid.probe_function[corner.probe] == kNoWeight) continue;
    weight[c] = tent(corner.local) * corner.tent_ratio;
    luminance[c] = luminanceOf(grid.probeLight(corner.probe));
    tents += weight[c];
    light += weight[c] * luminance[c];
  }
  if (!(tents > 0.0f)) {
    // the place is that of a probe without weight, where the tents of all others end: they count alike
    for (size_t c = 0; c < 8; ++c) {
      weight[c] = grid.probe_function[around.corners[c].probe] == kNoWeight ? 0.0f : 1.0f;
      tents += weight[c];
      light += weight[c] * luminanceOf(grid.probeLight(around.corners[c].probe));
    }
    if (tents == 0.0f) return;
  }
  // by tent over squared luminance; the floor keeps it continuous (docs/theory/probes.md)
  const float mean = light / tents + kNoLight;
  float sum = 0.0f;
  for (size_t c = 0; c < 8; ++c) {
    const float darker = mean / (luminance[c] + kDarkestFloor * mean);
    sum += weight[c] *= darker * darker;
  }
  // sure shares stay as they are; what the certainty lacks of 1 is spread over the corners
  const float scale = (1.0f - shares->certainty) / sum;
  const ProbeWeights sure = *shares;
  shares->count = 0;
  // both lists are in the order of corners: one walk merges them
  for (int c = 0, next = 0; c < 8; ++c) {
    float share = scale * weight[c];
    if (next < sure.count && sure.probe[next] == around.corners[c].probe) share += sure.weight[next++];
    if (!(share > 0.0f)) continue;
    shares->probe[shares->count] = around.corners[c].probe;
    shares->weight[shares->count++] = share;
  }
}

LightStatus sharesAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* shares) {
  weightsAround(grid, around, shares);
  normaliseWeights(shares);
  if (shares->certainty == 1.0f) return LightStatus::lit;
  if (!grid.light.empty()) addDarkest(grid, around, shares);
  return shares->count > 0 ? LightStatus::faint : LightStatus::unlit;
}

}  // namespace

const char* lightStatusName(LightStatus status) {
  switch (status) {
    case LightStatus::lit:
      return "lit";
    case LightStatus::faint:
      return "faint";
    case LightStatus::unlit:
      return "unlit";
    case LightStatus::outside:
      return "outside";
  }
  return "unknown";
}

LightStatus lookUpShares(const LightGrid& grid, const PositionM& position_m, ProbeWeights* shares) {
  ProbesAround around;
  shares->count = 0;
  if (grid.tree.lookUp(position_m, &around)) return sharesAround(grid, around, shares);
  if (grid.tree.lookUpNear(position_m, &around)) sharesAround(grid, around, shares);
  return LightStatus::outside;
}

LightStatus lookUpLight(const LightGrid& grid, const PositionM& position_m, float* light_9x3) {
  std::fill_n(light_9x3, kShFloats, 0.0f);
  ProbeWeights shares;
  const LightStatus status = lookUpShares(grid, position_m, &shares);
  if (grid.light.empty()) return status == LightStatus::outside ? status : LightStatus::unlit;
  for (int k = 0; k < shares.count; ++k) {
    const float* light = grid.probeLight(shares.probe[k]);
    for (int i = 0; i < kShFloats; ++i) light_9x3[i] += shares.weight[k] * light[i];
  }
  return status;
}

LightStatus lookUpIrradiance(const LightGrid& grid, const PositionM& position_m, const float* normal_3, float* rgb_3) {
  std::fill_n(rgb_3, kShChannels, 0.0f);
  if (!isDirection(normal_3)) return LightStatus::unlit;
  float light[kShFloats];
  const LightStatus status = lookUpLight(grid, position_m, light);
  const std::array<float, kShChannels> irradiance = flooredIrradiance(light, normal_3[0], normal_3[1], normal_3[2]);
  std::copy(irradiance.begin(), irradiance.end(), rgb_3);
  return status;
}

}  // namespace nlg
