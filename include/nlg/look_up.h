// Looks up light at a position of a light grid: the blend of the eight probes around it.
//
//     float rgb[3];
//     lookUpIrradiance(grid, {1.0, 1.5, 2.0}, normal, rgb);  // world, metres
//
// In solid, and at the few points in air that no probe around sees, weights cannot be trusted: there the darkest of the probes
// give the light, and the status says so (docs/theory/probes.md). A position outside all cells gets the light of the nearest used
// cell within one unit of the tree, so that an object that a rounding or a collision moved across the border is not dark.
//
// Single look-ups allocate nothing and cannot fail. Any number of threads may look up in one grid.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "nlg/light_grid.h"

namespace nlg {

inline constexpr float kLeastWeight = 1e-6f;  // smaller weights count as 0, because dividing by them could overflow
inline constexpr float kResidue =
    0.05f;  // share of the tent up to which a function counts as 0: the residue of a fit behind walls
// Share of the mean light around that is added to each probe's own, where the darkest probes count most.
inline constexpr float kDarkestFloor = 0.01f;

// The weights of the probes around a position, in the order of ProbesAround's corners.
struct ProbeWeights {
  uint32_t probe[8] = {};
  float weight[8] = {};  // of the first `count`: in [kLeastWeight, 1]; not normalised, in free space they sum to 1
  int count = 0;         // 0 to 8
  // In [0, 1]: the sum of the normalised weights. Below 1 if no probe has much more than the residue of its tent; the darkest
  // probes take the rest.
  float certainty = 1.0f;
};

// Computes the weights of the 8 probes around a position: with v = phi(local) / tent(local), clamped to [0, 1], a weight is tent
// * tent_ratio * max(0, v - kResidue) / (1 - kResidue). Bare tents have v = 1. Probes below kLeastWeight and those of kNoWeight
// are left out. The certainty is the weighted mean of v - kResidue over kResidue, at most 1.
//
// position_m   world, metres
// returns      false, with *weights unchanged, outside all cells (as ProbeTree::lookUp). True with a count of 0 if no probe has
//              weight: in solid, and at few points in air
bool lookUpWeights(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights);

// The same, for probes that ProbeTree::lookUp has found.
void weightsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights);

// Scales weights to sum to the certainty. They are then the shares of the blend.
// returns   false, with *weights unchanged, if the count is 0
bool normaliseWeights(ProbeWeights* weights);

enum class LightStatus : uint8_t {
  lit,      // lit by weighting functions
  faint,    // ProbeWeights::certainty is below 1; the darkest probes around give the rest
  unlit,    // no probe around has a function, or the grid has no light; the result is 0
  outside,  // in no cell, or not finite; the result is the light of the nearest used cell within one unit, or 0
};

// Returns "lit", "faint", "unlit" or "outside".
const char* lightStatusName(LightStatus status);

// Computes the shares of the probes around in the blend. They sum to 1; in a grid without light, to the certainty. The count is 0
// if there are none.
LightStatus lookUpShares(const LightGrid& grid, const PositionM& position_m, ProbeWeights* shares);

// Looks up radiance as spherical harmonics (light_grid.h): the blend of the probes' light.
//
// grid         one that checkLightGrid accepts; without light all positions inside are unlit
// position_m   world, metres
// light_9x3    kShFloats floats, overwritten; all 0 if there is no light
LightStatus lookUpLight(const LightGrid& grid, const PositionM& position_m, float* light_9x3);

// Looks up irradiance on a plane, which a diffuse surface multiplies by albedo / pi.
//
// normal_3   length 1, as {0, 1, 0}. If a component is not finite, or beyond ±kMaxNormal, rgb is 0 and the status is unlit
// rgb_3      3 floats, overwritten: flooredIrradiance of the light there
LightStatus lookUpIrradiance(const LightGrid& grid, const PositionM& position_m, const float* normal_3, float* rgb_3);

inline constexpr float kMaxNormal = 1.5f;  // limit of a direction's components, far above the rounding of length 1
inline bool isDirection(const float* normal_3) {
  // false of NaN, and other than <= it raises nothing there
  const auto fits = [](float number) { return std::islessequal(std::abs(number), kMaxNormal); };
  return fits(normal_3[0]) && fits(normal_3[1]) && fits(normal_3[2]);
}

// Working memory of lookUpIrradiances and lookUpLights, 1.2 MB: for any grid. Each thread needs its own.
class LookUpScratch {
 public:
  LookUpScratch();
  ~LookUpScratch();
  LookUpScratch(LookUpScratch&&) noexcept;
  LookUpScratch& operator=(LookUpScratch&&) noexcept;

  // of the library itself: look_up_batch.cpp
  struct Buffers;
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

// lookUpIrradiance for many positions, on vectors: 3 to 8 times as fast, fastest if positions in one cell are
// neighbours in the list. On one SIMD target the result of a position does not depend on the others. Between targets, and from
// lookUpIrradiance, results differ by rounding. Allocates nothing and cannot fail.
//
// positions_m   count of them
// normals_3     3 floats each
// rgb_3         3 floats each, overwritten
// status        count of them, overwritten
void lookUpIrradiances(const LightGrid& grid, const PositionM* positions_m, const float* normals_3, size_t count, float* rgb_3,
                       LightStatus* status, LookUpScratch* scratch);

// The same, with a scratch that it allocates.
void lookUpIrradiances(const LightGrid& grid, const PositionM* positions_m, const float* normals_3, size_t count, float* rgb_3,
                       LightStatus* status);

// lookUpLight for many positions: kShFloats floats each, overwritten.
void lookUpLights(const LightGrid& grid, const PositionM* positions_m, size_t count, float* light_9x3, LightStatus* status,
                  LookUpScratch* scratch);

// Light resampled into a dense box, for shaders that read 3-D textures instead of the grid. The talk does this at run time around
// the camera.
//
// The renderer interpolates between texels, also through walls: texels must be much smaller than the walls are thick.

// A box of texels. Their centres lie half a texel inside its faces, as samplers place them.
struct LightBox {
  PositionM low_m{}, high_m{};            // world, metres; finite
  std::array<uint32_t, 3> texel_count{};  // x, y, z

  size_t texelCount() const { return size_t{texel_count[0]} * texel_count[1] * texel_count[2]; }
  PositionM texelCentre(size_t x, size_t y, size_t z) const;
  // of the texel of this index; x is the fastest
  PositionM texelCentre(size_t texel) const {
    const size_t row = texel_count[0], slice = row * texel_count[1];
    return texelCentre(texel % row, texel % slice / row, texel / slice);
  }
};

// x is the fastest index, z the slowest.
struct ResampledLight {
  std::vector<float> light;         // kShFloats per texel: radiance as spherical harmonics; 0 if there is none
  std::vector<LightStatus> status;  // by texel, so that a renderer can fill texels that are faint, unlit or outside
};

// Returns lookUpLight at the centre of every texel, computed on vectors: 109 bytes per texel.
ResampledLight resampleLight(const LightGrid& grid, const LightBox& box, LookUpScratch* scratch);

}  // namespace nlg
