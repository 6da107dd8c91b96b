#include "bake/policy_options.h"

#include "runtime_eval/policy/stage_plan.h"
#include "tool/error.h"

namespace nlg {

void describePolicy(PolicyOptions& options, OptionTable& table) {
  table.group("Policy: which theta are fitted, and how long");
#define NLG_POLICY_OPTION(type, name, value, low, high, help) \
  table.add(#name, &options.name, help, static_cast<type>(low), static_cast<type>(high));
#include "nlg/policy_options.def"
}

ThetaPrecision thetaPrecisionFromName(const std::string& name) {
  if (name == "float32") return ThetaPrecision::float32;
  if (name == "float16") return ThetaPrecision::float16;
  if (name == "int8") return ThetaPrecision::int8;
  throw UsageError("theta_precision", "float32, float16 or int8", "'" + name + "'");
}

std::string stagesHelp(const PolicyOptions& options) {
  std::string text =
      "Stages of the policy, by representation (thresholds rise for weights that err on the bare tent: docs/theory/math.md §6):\n"
      "";
  for (const char* name : kRepresentationNames) {
    Representation representation;
    findRepresentation(name, &representation);
    text += std::string("  ") + name + '\n';
    for (const StagePlan& plan : stagesOf({representation, representation.hasLinearOutput(), 0.0}, options))
      text += "    " + describe(plan) + '\n';
  }
  return text;
}

}  // namespace nlg
