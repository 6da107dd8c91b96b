// How well functions do what solved ones do, in one small scene.
#pragma once

#include "validate/solved/diffusion_rule.h"
#include "validate/solved/joint_solve.h"

namespace nlg {

struct SolveSetup {
  SampleOptions samples;
  LightOptions light;
  SolveOptions solve;
};

// Everything that a comparison reads, made once a scene.
class SolvedScene {
 public:
  SolvedScene(const std::string& name, const SolveSetup& setup);

  SmallScene small;
  Scene scene;
  RayScene rays;
  SamplePoints points;
  PointLinks links;
  LightField light;
  LinkTable table;
  std::vector<ProbeView> views;
  SolvedFunctions solved;
  // N x 8: metres of the shortest way through air from each point to each probe around it, along linked points; infinity: none
  BlendWeights path_m;
  // N: a probe whose tent is at least .02 here does not see the point. Only there do rules differ.
  std::vector<uint8_t> occluded;
};

// Errors are in shares of the lighting's root mean square, at test points under test lamps; the probes' values are the
// best ones for these functions at the fit points, so that every variant is judged by its functions alone.
struct Quality {
  double rmse = 0.0;
  double rmse_occluded = 0.0;  // at occluded points
  double unlit_share = 0.0;    // of the occluded points: no probe around has weight; they count as black
  double leak =
      0.0;  // occluded points: mean weight of probes behind a wall (it does not see the point, and no way below 2 spacings)
  double step_p99 = 0.0;         // half the sum of |changes of w| between slice pixels that see each other, one of them occluded
  double distance_solved = 0.0;  // root mean square over occluded points, and their probes, of w − solved w
};

// Half of the sum over all probes of |w(a) − w(b)|, of normalised weights: 0 for equal ones, 1 when no probe counts at both points.
double weightChange(const SamplePoints& points, const BlendWeights& w, uint32_t a, uint32_t b);

// weights   N x 8, not normalised
// at        the points that figures are taken at
Quality judge(const SolvedScene& scene, const BlendWeights& weights, PointUse at = PointUse::test);

}  // namespace nlg
