// Options of a bake: section `bake` of pipeline.yaml.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/policy_options.h"
#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "scene/lights/light_options.h"
#include "scene/scene_source.h"
#include "tool/command/options.h"

namespace nlg {

struct BakeOptions {
  // Whose shipped weights a bake takes that names none. tent_mlp4 lights levels as well as tent_mlp does, in two thirds of the
  // bytes and of the time (docs/reference/light.md).
  std::vector<std::string> representation = {"tent_mlp4"};
  // 0: what chooseSpacing says (probe_placement.h), with which nlg-bake, nlg-view and nlg-validate views begin
  double spacing_m = 1.0;
  double density_growth = 0.5;
  std::vector<std::string> extent_m;
  bool align_lattice = false;
  uint64_t max_probes = 1000000;  // a scene that would have more is refused: some 6 GB of memory
  bool air_only = true;           // cells in solid, and probes that only they read, are left out
  // Functions are what probes see at 1,024 points, and their theta one pass of the network: no links, no diffusion, no fits, no check.
  bool draft = false;
  PointChoice points() const { return draft ? PointChoice::samples : PointChoice::all; }
  ThetaStage lastStage() const { return draft ? ThetaStage::network : ThetaStage::rounding; }
  DiffusionOptions diffusion;
  double duplicate_rms = 0.5;
  int duplicate_validity_points = 16;
  PolicyOptions policy;
  LightOptions scene_light;  // sky and sun
  SceneReading reading;
  std::string light = "solved";      // how probes are lit; "none": they are not
  std::string light_direct = "all";  // which light of lamps and suns probes hold themselves
  int light_samples = 12;            // in air, of every cell
  int light_rays = 0;                // of every place; 0: raysOfPlace
  int light_probe_rays = 512;        // of every probe, when light is "point"
  bool light_cache = true;           // bounces are kept on surfaces, where they are traced
  double light_pull = 0.1;
  double light_dark_share = 0.03;
  double light_outlier = 1.0;
  double thin_error = 0.0;      // of thinning.h; 0: nothing is left out
  double refine_seconds = 0.0;  // 0: as long as it takes
  std::string theta_precision =
      thetaPrecisionName(PolicyOptions{}.theta_precision);  // becomes the policy's by takeThetaPrecision
  double light_error = kLightError;                         // that the file's form of light may add (packed_light.h)
  double max_bytes = 0.0;                                   // of the file; 0: as many as it takes
  std::string simd;                                         // empty: the best
  int threads = 0;                                          // 0: as many as the machine runs at once
  uint64_t seed = 1;
};

// Of thin_error: beyond it little is left of a level's light.
inline constexpr double kMostThinError = 0.5;

// Of the options that say how probes are lit.
inline constexpr const char* kLightGroup = "Light";

int threadsOf(const BakeOptions& options);

// The policy rounds as theta_precision says: whatever bakes with options that were read calls this first.
// throws   UsageError on a name of none
void takeThetaPrecision(BakeOptions* options);

// Adds every option to the table of the section `bake`.
void describe(BakeOptions& options, OptionTable& table);

}  // namespace nlg
