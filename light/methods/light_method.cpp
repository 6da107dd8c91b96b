#include "light/methods/light_method.h"

namespace nlg {

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

std::function<LightAnswer(const glm::dvec3&, const glm::vec3&)> blendedLight(const Weighting& weighting,
                                                                             const std::vector<LightSh>& light) {
  return [&](const glm::dvec3& position_m, const glm::vec3& normal) {
    const ProbeBlend blend = weighting.blendAt(position_m, normal);
    LightSh sum{};
    for (int i = 0; i < blend.count; ++i) {
      for (int k = 0; k < kShCount; ++k) sum[k] += blend.weight[i] * light[blend.probe[i]][k];
    }
    return LightAnswer{glm::max(irradiance(sum, normal), glm::vec3(0.0f)), blend.reach};
  };
}

}  // namespace nlg
