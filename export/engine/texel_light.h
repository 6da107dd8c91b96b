// Lights the texels of an engine's own grid from a scene: placed, as engines do, or solved for the look-up that the engine has.
//
// A look-up that is linear in what texels hold is one row of weights a place, and that is all that the solve of probes asks for
// (light/probe_light.h): trilinear, from a place moved along the normal, without texels that the engine leaves out. So blends give the
// light that is there, where texels with the light of their own place leak through walls.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "export/engine/engine_format.h"
#include "light/probe_light.h"
#include "validate/light/light_figures.h"

namespace nlg {

// How an engine blends texels at a place.
struct TexelLookUp {
  LightBox box;
  double bias = 0.0;  // texels that a position is moved by, along the normal, before it is looked up
  // By texel, where the engine leaves texels out; empty: it reads all of them, and at the edge of the box what stands nearest. Texels
  // that are left out, and what would lie outside the box, have no share; if less than kWhole is left, shares are scaled up.
  std::vector<uint8_t> is_valid;

  static constexpr float kWhole = 0.99f;

  // position_m   world
  // weights      of texels, x the fastest index; they sum to 1, or a little less as above
  void weightsAt(const PositionM& position_m, const float* normal_3, ProbeWeights* weights) const;
  std::array<double, 3> texelM() const;  // width, along each axis
};

// A scene whose light is measured at places, once for all texels.
struct MeasuredScene {
  const LightTransport& transport;
  const std::vector<glm::dvec3>& places;    // in air, relative to the scene's origin
  const std::vector<LightSh>& place_light;  // what arrives there
  const ProbeLightOptions& options;
  int thread_count = 1;
};

// Light that arrives at each texel in air; the others have the mean of their neighbours, as filledVolume fills them.
LightVolume placeTexels(const MeasuredScene& scene, const LightBox& box);

// By texel, as the solve has it.
std::vector<LightSh> lightOf(const LightVolume& volume);

// By texel: light of which the look-up's blends give what was measured.
// place_light   in place of the scene's own, in whatever basis
std::vector<LightSh> solveTexels(const MeasuredScene& scene, const TexelLookUp& look_up, const std::vector<LightSh>& place_light);

// position_m   of the scene
PositionM inWorld(const Scene& scene, const glm::dvec3& position_m);

// For engines that move each look-up along the normal: squares of irradiance by normal, each of which reads texels of its own. From behind a
// wall a texel then lights what faces it, and else its own side. Air gains most; close to surfaces solveTexels may err less.
// places_m   world
// light      by texel, to begin with; it holds those that few places read
std::vector<LightSh> solveByNormal(const TexelLookUp& look_up, const std::vector<PositionM>& places_m,
                                   const std::vector<LightSh>& place_light, std::vector<LightSh> light,
                                   const ProbeLightOptions& options, int thread_count);

// Errors of what an engine shows, at places of their own: uniform in air, and before surfaces (validate/light/light_places.h).
class TexelJudge {
 public:
  // places   of each group
  // seed     of them: of one that chooses, another than that of one that reports
  TexelJudge(const MeasuredScene& scene, const ExtentBox& extent, int places, uint64_t seed);
  // Truth is path traced, with so many rays a place.
  void trace(int rays);
  // Truth is what this says of a place and a normal; places of which it says nothing are left out.
  void take(const std::function<bool(const glm::dvec3& position_m, const float* normal_3, glm::vec3* irradiance)>& truth);

  LightFigures errorOf(const EngineIrradiance& shown) const;

  size_t placeCount() const { return places_.places.size(); }
  double noise() const { return truth_.noise; }

 private:
  const MeasuredScene& scene_;
  uint64_t seed_;
  LightPlaces places_;
  LightTruth truth_;
};

// The command nlg-export engine SCENE --format FORMAT --out FOLDER
int engineMain(int argc, char** argv);

}  // namespace nlg
