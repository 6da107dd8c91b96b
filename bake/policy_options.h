// Adds the policy's options to an option table, with the same keys for every tool.
#pragma once

#include <string>

#include "nlg/policy.h"
#include "tool/command/options.h"

namespace nlg {

// Every option of the policy but theta_precision, which only those take who store theta.
void describePolicy(PolicyOptions& options, OptionTable& table);

// "float32", "float16" or "int8", as the option theta_precision takes them.
// throws   UsageError on any other name
ThetaPrecision thetaPrecisionFromName(const std::string& name);

// The stages that every representation goes through with these options, a line each, for --help. Weights are taken to hold an exact
// last layer where the output is linear; thresholds may rise for a generator that is wrong about the tent.
std::string stagesHelp(const PolicyOptions& options);

}  // namespace nlg
