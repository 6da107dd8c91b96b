// What a bake leaves out where a scene does not need it.
#pragma once

namespace nlg {

// All but the last as a bake has them. measureNeeds (needs_measurement.h) turns one at a time to see what it is worth; nothing else does.
struct BakeSavings {
  bool free_space = true;         // probes without geometry in their support have no visibility, no function, no theta
  bool in_solid = true;           // nor have probes in solid
  bool empty = true;              // a function that is 0 everywhere has no theta
  bool duplicates = true;         // functions that are all but the same share one theta
  bool larger_generators = true;  // only the smallest representation's generator runs where its theta is enough
  bool correction = true;         // a theta that is right is not corrected
  bool refinement = true;         // a theta that passes the check is not refined
  bool bare_tent = true;          // nor has a function that is all but the bare tent: its probe counts as free space
  bool passing_tent = false;      // nor one whose bare tent passes the check: no bake does that yet
};

}  // namespace nlg
