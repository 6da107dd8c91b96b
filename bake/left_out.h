// Which probes a bake leaves out because the scene does not need them.
#pragma once

namespace nlg {

// All as a bake has them. measureSavings (savings_measurement.h) turns one at a time to see what it is worth; nothing else does.
struct LeftOut {
  bool free_space = true;  // probes without geometry in their support have no visibility, no function, no theta
  bool in_solid = true;    // nor have probes in solid without an eye in air
  bool empty = true;       // a function that is 0 everywhere has no theta
  bool duplicates = true;  // functions that are all but the same share one theta
};

}  // namespace nlg
