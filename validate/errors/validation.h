// How good exported generators are on held-out scenes, through the bake's own policy, against long fits and the bare tent.
#pragma once

#include <string>
#include <vector>

#include "validate/errors/validate_options.h"

namespace nlg {

struct ValidationRequest {
  std::vector<std::string> weights, held_out, training;  // training: only counted
  std::string out_dir;
};

// Writes summary.json, functions.csv and slices.json: docs/reference/formats.md. No error depends on the threads.
// table    the settings, for the provenance
// throws   InputError on files that cannot be read or do not belong together; NumericalError when an error is not finite
void validate(const ValidationRequest& request, ValidateOptions options, const OptionTable& table);

}  // namespace nlg
