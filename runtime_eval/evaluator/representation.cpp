#include "runtime_eval/evaluator/representation.h"

#include <utility>

namespace nlg {

const PointOrder& pointOrder(const Representation& representation) {
  return representation.isField() ? cellOrder(representation.resolution) : stratumOrder();
}

void mirrorTheta(const Representation& representation, int mirror, float* theta) {
  if (!representation.isField()) {
    for (int unit = 0; unit < representation.shape().first; ++unit) {
      for (int axis = 0; axis < 3; ++axis) {
        if (mirror >> axis & 1) theta[3 * unit + axis] = -theta[3 * unit + axis];
      }
    }
    return;
  }
  const int resolution = representation.resolution;
  for (int node = 0; node < resolution * resolution * resolution; ++node) {
    int image = 0, stride = 1;
    for (int axis = 0, rest = node; axis < 3; ++axis, stride *= resolution, rest /= resolution) {
      const int along = rest % resolution;
      image += stride * (mirror >> axis & 1 ? resolution - 1 - along : along);
    }
    if (image <= node) continue;
    std::swap(theta[2 * node], theta[2 * image]);
    std::swap(theta[2 * node + 1], theta[2 * image + 1]);
  }
}

const char* representationName(const Representation& representation) {
  if (!representation.isField()) return kNetworks[static_cast<int>(representation.kind)].name;
  for (const FieldKind& field : kFields) {
    if (field.resolution == representation.resolution) return field.name;
  }
  return "unknown";
}

std::string representationNames() {
  std::string text;
  const size_t count = std::size(kRepresentationNames);
  for (size_t i = 0; i < count; ++i)
    text += (i == 0 ? "" : i + 1 == count ? " or " : ", ") + std::string(kRepresentationNames[i]);
  return text;
}

bool findRepresentation(std::string_view name, Representation* representation) {
  for (int i = 0; i < kNetworkCount; ++i) {
    if (name != kNetworks[i].name) continue;
    *representation = {static_cast<RepresentationKind>(i)};
    return true;
  }
  for (const FieldKind& field : kFields) {
    if (name != field.name) continue;
    *representation = Representation::productField(field.resolution);
    return true;
  }
  return false;
}

}  // namespace nlg
