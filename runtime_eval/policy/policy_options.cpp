#include "nlg/policy.h"

namespace nlg {

const char* outOfRange(const PolicyOptions& options) {
// a NaN is in no range
#define NLG_POLICY_OPTION(type, name, value, low, high, help) \
  if (!(options.name >= (low) && options.name <= (high))) return #name;
#include "nlg/policy_options.def"
  return nullptr;
}

}  // namespace nlg
