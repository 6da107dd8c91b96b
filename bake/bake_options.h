// The settings of a bake: section `bake` of pipeline.yaml.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/refinement.h"
#include "runtime_eval/fit/representation_choice.h"
#include "tool/options.h"

namespace nlg {

struct BakeOptions {
  std::vector<std::string> representation = {
      "tent_mlp"};  // whose shipped weights a bake takes that names none: the default of all
  double spacing_m = 1.0;
  double density_growth = 0.5;
  std::vector<std::string> extent_m;
  DiffusionOptions diffusion;
  double duplicate_rms = 0.5;
  int duplicate_validity_points = 16;
  double bare_tent_rmse = 0.002;  // a function whose bare tent is not further off has no theta; 0: every function has one
  CorrectionOptions correction;
  RefinementOptions refinement;
  double refine_seconds = 0.0;  // 0: as long as it takes
  ChoiceOptions choice;
  std::string generator_precision = "float32";
  std::string theta_precision = "float32";
  std::string simd;  // empty: the best
  int threads = 0;   // 0: as many as the machine runs at once
  uint64_t seed = 1;
};

// Adds every option to the table of the section `bake`.
void describe(BakeOptions& options, OptionTable& table);

}  // namespace nlg
