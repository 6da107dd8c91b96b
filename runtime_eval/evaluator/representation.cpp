#include "runtime_eval/evaluator/representation.h"

namespace nlg {

const char* representationName(const Representation& representation) { return representation.tent_factor ? "tent_mlp" : "mlp"; }

bool findRepresentation(std::string_view name, Representation* representation) {
  for (const bool tent_factor : {false, true}) {
    const Representation candidate{tent_factor, Representation{}.slope};
    if (name == representationName(candidate)) {
      *representation = candidate;
      return true;
    }
  }
  return false;
}

}  // namespace nlg
