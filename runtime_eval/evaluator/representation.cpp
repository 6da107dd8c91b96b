#include "runtime_eval/evaluator/representation.h"

#include <iterator>

namespace nlg {
namespace {

// In the order of kRepresentationNames.
constexpr Representation kRepresentations[] = {
    Representation::mlp(),           Representation::tentMlp(),       Representation::productField(3),
    Representation::productField(5), Representation::productField(7), Representation::productField(9),
};
static_assert(std::size(kRepresentations) == std::size(kRepresentationNames));

}  // namespace

const PointOrder& pointOrder(const Representation& representation) {
  return representation.isField() ? cellOrder(representation.resolution) : stratumOrder();
}

const char* representationName(const Representation& representation) {
  for (size_t i = 0; i < std::size(kRepresentations); ++i) {
    const Representation& candidate = kRepresentations[i];
    if (candidate.kind == representation.kind && candidate.resolution == representation.resolution)
      return kRepresentationNames[i];
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
  for (size_t i = 0; i < std::size(kRepresentations); ++i) {
    if (name != kRepresentationNames[i]) continue;
    *representation = kRepresentations[i];
    return true;
  }
  return false;
}

}  // namespace nlg
