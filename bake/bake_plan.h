// Estimates probes, memory and time of a bake before it starts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "datagen/probes/probe_placement.h"

namespace nlg {

// Where a bake places its probes: by its options, else where the scene's author says, else in the scene's bounds and what lies in
// reach of them (scene_size.h).
// chosen   receives how the spacing was chosen, where nobody named one; may be null
// throws   UsageError on an extent_m that is none
ProbePlacementOptions placementOf(const SceneSource& source, const BakeOptions& options,
                                  std::optional<ChosenSpacing>* chosen = nullptr);

struct BakePlan {
  double unit_m = 0.0;       // of the file; 0: its format has its own
  glm::dvec3 scene_m{0.0};   // sides of the scene
  glm::dvec3 extent_m{0.0};  // sides of what has probes
  double spacing_m = 0.0;
  std::optional<ChosenSpacing> chosen;       // where nobody named a spacing
  size_t density_boxes = 0;                  // boxes with a spacing of their own
  std::vector<std::string> outside;          // nodes of such boxes beyond the extent
  double probes = 0.0;                       // estimated, before those without air are left out
  double machine_bytes = 0.0;                // of memory that this machine has
  double memory_bytes = 0.0, seconds = 0.0;  // rough: mostly within a factor of two
};

// Takes about a second for a million triangles, and half a second more with generators: some probes' functions and theta are made to see what
// they take.
// generators   of the bake; none: light alone is made
// throws       UsageError on a setting that cannot be used, and on far too many probes
BakePlan planBake(const SceneSource& source, const BakeOptions& options, const std::vector<Generator>& generators,
                  int thread_count);

// A line; another one where the spacing was chosen.
std::string toText(const BakePlan& plan, int thread_count);

}  // namespace nlg
