#include "light/methods/target_functions.h"

#include <bit>

#include "light/methods/true_weights.h"
#include "runtime_eval/light_grid/light_grid.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {

size_t TargetFunctions::PlaceHash::operator()(const glm::dvec3& place) const {
  return mixSeed(std::bit_cast<uint64_t>(place.x), std::bit_cast<uint64_t>(place.y), std::bit_cast<uint64_t>(place.z));
}

TargetFunctions::TargetFunctions(const std::vector<glm::dvec3>& places, const ProbeSet& probes, const RayScene& rays,
                                 const LinkTable& links, const DiffusionOptions& diffusion, int thread_count) {
  const std::vector<TrueWeights> weights = trueWeights(places, probes.tree, rays, links, diffusion, thread_count);
  for (size_t i = 0; i < places.size(); ++i) {
    ProbesAround around;
    ProbeBlend blend;
    const bool is_inside = probes.tree.lookUp({places[i].x, places[i].y, places[i].z}, &around);
    for (int c = 0; c < kCornerCount && is_inside; ++c) {
      if (weights[i].target[c] >= kLeastWeight) blend.add(weights[i].probe[c], weights[i].target[c]);
    }
    blend.finish(Reach::lit);
    if (!is_inside) blend.reach = Reach::outside;
    blends_.emplace(places[i], blend);
  }
}

ProbeBlend TargetFunctions::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  const auto found = blends_.find(position_m);
  NLG_CHECK((found != blends_.end()), ==, true);
  return found->second;
}

}  // namespace nlg
