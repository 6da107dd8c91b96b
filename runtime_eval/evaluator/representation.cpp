#include "runtime_eval/evaluator/representation.h"

namespace nlg {

const PointOrder& pointOrder(const Representation& representation) {
  return representation.isField() ? cellOrder(representation.resolution) : stratumOrder();
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
