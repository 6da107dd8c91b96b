#include "validate/light/grid_weighting.h"

namespace nlg {

ProbeBlend GridWeighting::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  const glm::dvec3 world = position_m + origin_m_;
  ProbeBlend blend;
  ProbeWeights weights;
  if (!lookUpWeights(grid_, {world.x, world.y, world.z}, &weights)) {
    blend.reach = Reach::outside;
    return blend;
  }
  const bool by_functions = weights.count > 0;
  if (!by_functions) lookUpTents(grid_, {world.x, world.y, world.z}, &weights);
  for (int i = 0; i < weights.count; ++i) blend.add(weights.probe[i], weights.weight[i]);
  blend.finish(by_functions ? Reach::lit : Reach::fallback);
  return blend;
}

}  // namespace nlg
