#include "light/methods/grid_weighting.h"

#include "runtime_eval/light_grid/irradiance.h"

namespace nlg {
namespace {

Reach reachOf(LightStatus status) {
  return status == LightStatus::lit     ? Reach::lit
         : status == LightStatus::faint ? Reach::fallback
         : status == LightStatus::unlit ? Reach::unlit
                                        : Reach::outside;
}

}  // namespace

ProbeBlend GridWeighting::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  const glm::dvec3 world = position_m + origin_m_;
  ProbeWeights shares;
  const LightStatus status = lookUpShares(grid_, {world.x, world.y, world.z}, &shares);
  ProbeBlend blend;
  for (int i = 0; i < shares.count; ++i) blend.add(shares.probe[i], shares.weight[i]);
  blend.reach = reachOf(status);
  return blend;
}

ProbeWeights GridWeighting::weightsAt(const glm::dvec3& position_m, const glm::vec3&) const {
  ProbeWeights weights;
  weights_of_grid_(position_m, &weights);
  return weights;
}

std::function<LightAnswer(const glm::dvec3&, const glm::vec3&)> lookedUpLight(const LightGrid& grid, const glm::dvec3& origin_m) {
  return [&grid, origin_m](const glm::dvec3& position_m, const glm::vec3& normal) {
    const glm::dvec3 world = position_m + origin_m;
    LightAnswer answer;
    answer.reach = reachOf(lookUpIrradiance(grid, {world.x, world.y, world.z}, &normal.x, &answer.irradiance.x));
    return answer;
  };
}

}  // namespace nlg
