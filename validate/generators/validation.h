// Measures exported generators on held-out scenes, through the bake's own policy, against long fits and the bare tent.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/policy_options.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/direct.h"
#include "tool/command/options.h"

namespace nlg {

// The settings of a validation: section `validate` of pipeline.yaml.
struct ValidateOptions {
  PolicyOptions policy;  // the bake's
  std::string theta_precision =
      thetaPrecisionName(PolicyOptions{}.theta_precision);  // becomes the policy's when a validation begins
  double hard_tent_rmse = 0.01;                             // functions whose bare tent is at least so wrong are hard
  int direct_functions = 300;                               // the sample: functions that take a theta, on which long fits run
  DirectOptions direct;
  int threads = 0;  // 0: as many as the machine runs at once
  uint64_t seed = 1;

  int threadCount() const;
};

// Adds every option to the table of the section `validate`.
void describe(ValidateOptions& options, OptionTable& table);

struct ValidationRequest {
  std::vector<std::string> weights, held_out, training;  // training: only counted
  std::string out_dir;
};

// Writes summary.json, functions.csv and slices.json: docs/reference/formats.md. No error depends on the threads.
// table    the settings, for the provenance
// throws   InputError on files that cannot be read or do not belong together; NumericalError when an error is not finite
void validate(const ValidationRequest& request, ValidateOptions options, const OptionTable& table);

}  // namespace nlg
