// A sine network for the light of a whole scene, by position and normal.
//
// After "SIREN GI" (Zhihu, March 2023: the winner of the students' contest of High Performance Graphics 2022), its network of position and
// normal followed by that of the view, without the view, which diffuse light does not depend on: layers of 64, the first with a
// frequency of 20; targets ln(10 light + 1). There each object of a Cornell box has its own, and AdaBound trains it; here it is Adam.
#pragma once

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

struct SirenOptions {
  int width = 64;
  int hidden_layers = 6;          // >= 1
  float first_frequency = 20.0f;  // radians from the middle of the scene's cube to its face
  int64_t batch = 4096;
  TrainingOptions training;
};

// split   learned not empty
LearnedLight trainSiren(const LitPlaces& lit, const PlaceSplit& split, const SirenOptions& options);

}  // namespace nlg
