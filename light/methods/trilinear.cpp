#include "light/methods/trilinear.h"

namespace nlg {

ProbeBlend Trilinear::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  ProbeBlend blend;
  ProbesAround around;
  if (!probes_.tree.lookUp({position_m.x, position_m.y, position_m.z}, &around)) {
    blend.reach = Reach::outside;
    return blend;
  }
  ProbeBlend unseen;
  for (const ProbeAround& corner : around.corners) {
    const float weight = tent(corner.local) * corner.tent_ratio;
    if (kind_ != TrilinearKind::all && !probes_.is_in_air[corner.probe]) continue;
    const bool is_unseen = kind_ == TrilinearKind::visible && weight > 0.0f &&
                           rays_.isBlocked(glm::vec3(position_m), glm::vec3(probes_.position_m[corner.probe]));
    (is_unseen ? unseen : blend).add(corner.probe, weight);
  }
  if (blend.count > 0) {
    blend.finish(Reach::lit);
    return blend;
  }
  unseen.finish(Reach::fallback);
  return unseen;
}

}  // namespace nlg
