#include "runtime_eval/light_grid/irradiance.h"

#include <algorithm>

namespace nlg {
namespace {

LightStatus sharesAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* shares) {
  weightsAround(grid, around, shares);
  if (!normaliseWeights(shares)) return LightStatus::unlit;
  return shares->certainty < 1.0f ? LightStatus::faint : LightStatus::lit;
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
  const std::array<float, kShChannels> irradiance = shIrradiance(light, normal_3[0], normal_3[1], normal_3[2]);
  for (int c = 0; c < kShChannels; ++c) rgb_3[c] = std::max(0.0f, irradiance[c]);
  return status;
}

}  // namespace nlg
