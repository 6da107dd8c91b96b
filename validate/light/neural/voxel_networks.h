// One network per voxel of 4 m for its light: the talk's first prototype.
//
// 6 → 128 → 128 → 3 with ReLU: position in the voxel, in [-1, 1]³, and normal to colour, by a relative loss (the talk: with squares it
// ignores what is dark; SMAPE). Neighbours know nothing of each other: the talk gave it up for its cost, and the next one began with
// blends because of the edges between voxels.
#pragma once

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

struct VoxelNetworksOptions {
  double voxel_m = 4.0;
  int width = 128;  // of the two hidden layers
  int64_t batch = 256;
  TrainingOptions training;  // of each voxel
  int thread_count = 1;
};

// Voxels with too few places to learn from (placesByVoxel) have no network: the nearest that has one answers.
//
// split    learned not empty
// throws   InputError where no voxel has places enough
LearnedLight trainVoxelNetworks(const LitPlaces& lit, const PlaceSplit& split, const VoxelNetworksOptions& options);

}  // namespace nlg
