// Jitters a scene: variants for training with moved, turned, scaled and dropped objects.
#pragma once

#include <cstdint>

#include "scene/model/scene.h"

namespace nlg {

struct JitterOptions {
  double move_m = 0.5;            // each movable object shifts by up to this along x and z, by a tenth of it along y
  double turn_degrees = 20.0;     // and turns about the vertical axis through its centre by up to this
  double scale = 0.15;            // and scales by a factor in [1 - scale, 1 + scale]
  double drop_share = 0.1;        // this share of the movable objects is left out
  double structure_share = 0.35;  // a component larger than this share of the scene is structure and stays
};

// A variant of scene: jitter 0 is the scene itself; every other number is another draw, a pure function of
// (scene, options, jitter), the same on every machine. Objects are split into connected components first. A variant has the
// scene's lamps, suns and sky where they were, and no baked light.
Scene jitterScene(const Scene& scene, const JitterOptions& options, uint64_t jitter);

}  // namespace nlg
