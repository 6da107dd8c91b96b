// Lighting at points of a small scene, under many lamps one at a time: what solved weighting functions have to reproduce.
//
// Surfaces are diffuse. Every surface is cut into elements (voxels of half a metre by the way they face); their radiosity comes
// from rays between them, with 16 bounces; rays from a point gather it. A lamp is a patch of surface of about a metre and a
// quarter that shines by itself: wherever light can come from, some lamp has it come from there. Points gather what surfaces send
// back, not the lamp's own light: near a lamp that varies faster than any blend of probes a metre apart, and it would rule the
// squares.
#pragma once

#include "validate/solved/sample_points.h"

namespace nlg {

inline constexpr int kAxisCount = 6;  // irradiance on planes that face +x, -x, +y, -y, +z, -z

// N x S numbers, row-major: S signals at each of N points.
struct Signals {
  int count = 0;  // S
  std::vector<float> value;

  const float* row(size_t point) const { return &value[point * static_cast<size_t>(count)]; }
  float* row(size_t point) { return &value[point * static_cast<size_t>(count)]; }
};

struct LightOptions {
  int rays_per_point = 1024;
  int rays_per_element = 512;
  float element_m = 0.5f;
  double lamp_m = 1.25;  // a thin wall must stand on a multiple of both sides, or a voxel holds the floor of two rooms
  int fit_lamps = 40;    // at most; scenes with fewer patches have fewer
  int test_lamps = 8;    // no solve sees these
  uint64_t seed = 1;
};

struct LightField {
  Signals fit, test;  // signal 6 lamp + axis; each lamp's root mean square over all points and axes is 1
};

// throws InputError when the scene has fewer than two patches that could be lamps
LightField gatherLight(const RayScene& rays, const Scene& scene, const SamplePoints& points, const LightOptions& options);

}  // namespace nlg
