
#include <utility>

#include "runtime_eval/evaluator/kernel_shape.h"

namespace nlg {

Representation Representation::code(SharedDictionary dictionary) {
  return {RepresentationKind::code, 0.01f, dictionary->resolution(), dictionary->codeCount(), std::move(dictionary)};
}

const PointOrder& pointOrder(const Representation& representation) {
  return representation.isNetwork() ? stratumOrder() : cellOrder(representation.resolution);
}

const char* representationName(const Representation& representation) {
  if (representation.isNetwork()) return representation.network().name;
  for (const CodeKind& code : kCodes) {
    if (representation.isCode() && code.count == representation.code_count) return code.name;
  }
  for (const FieldKind& field : kFields) {
    if (representation.isField() && field.resolution == representation.resolution) return field.name;
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
    *representation = {};
    representation->kind = static_cast<RepresentationKind>(i);
    return true;
  }
  for (const FieldKind& field : kFields) {
    if (name != field.name) continue;
    *representation = Representation::productField(field.resolution);
    return true;
  }
  for (const CodeKind& code : kCodes) {
    if (name != code.name) continue;
    *representation = {RepresentationKind::code, 0.01f, kMaxBrickResolution, code.count, nullptr};
    return true;
  }
  return false;
}

}  // namespace nlg
