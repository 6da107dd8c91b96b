// A neural irradiance volume: a small network maps hash-grid features of the point, and the normal, to irradiance.
//
// After the paper of that name (Computer Graphics Forum, 2026), with what it takes from instant neural graphics primitives. Features and
// network are trained together on light at places in air, and are float16 in the look-up.
#pragma once

#include <cstdint>

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

struct NeuralVolumeOptions {
  int table_log2 = 14;  // rows of a level: 2^table_log2 at most; 4 … 24
  int width = 64;       // of the two hidden layers
  int64_t batch = 4096;
  TrainingOptions training;
};

// split   learned not empty
LearnedLight trainNeuralVolume(const LitPlaces& lit, const PlaceSplit& split, const NeuralVolumeOptions& options);

}  // namespace nlg
