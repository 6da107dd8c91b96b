// Light as a latent per voxel of 4 m, by an encoder and a decoder: the talk's second prototype.
//
// After generative query networks (Eslami et al., "Neural scene representation and rendering", Science 2018). The encoder reads one
// observation: a place in the voxel and the light that was measured there. The mean of what it says of all of a voxel's observations is
// the latent, and is all that a voxel stores. The decoder, six layers of 512, reads latent, position and normal, and says colour. Both
// are trained together, with few observations by chance; a bake is then one pass of the encoder. The source's latent is a Gaussian,
// whose variance says whether to observe more; here it is its mean alone.
#pragma once

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

// Networks are for all levels, and learn from some.
enum class LatentVoxels {
  own,    // learned from the voxels that they answer for
  other,  // … from the other half of them: what a level has that was not learned from. Trains twice
};

struct LatentBakeOptions {
  LatentVoxels voxels = LatentVoxels::own;
  double voxel_m = 4.0;
  int latent = 64;  // numbers; at most 506
  int decoder_width = 512, decoder_layers = 6;
  int batch_voxels = 8, batch_places = 64;  // of a step: voxels, and of each as many observations and as many answers
  TrainingOptions training;
};

// Voxels with too few places (placesByVoxel) have the latent of the nearest that has enough. Bytes hold one decoder, and no encoder.
//
// split    learned not empty
// throws   InputError where fewer than two voxels have places enough, and `other` is asked for
LearnedLight trainLatentBake(const LitPlaces& lit, const PlaceSplit& split, const LatentBakeOptions& options);

}  // namespace nlg
