// Light at a position, out of a light grid: the blend of the eight probes around it.
//
// Where no weight can be trusted, in solid and at the few points in air that no probe around sees, the darkest of these probes give the light,
// and the status says so (docs/theory/probes.md). A position in no cell takes the light of the nearest used cell within one unit of the tree,
// so that an object that a rounding or a collision put behind the border is not dark.
//
// Single look-ups take no memory and cannot fail. Any number of threads may look up in one grid.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "nlg/light_grid.h"

namespace nlg {

inline constexpr float kLeastWeight = 1e-6f;  // a smaller weight counts as 0: its quotient could overflow
inline constexpr float kResidue =
    0.05f;  // share of its tent up to which a function counts as 0: what a fit may leave behind walls
inline constexpr float kDarkestFloor = 0.01f;  // of the mean light around: added to a probe's own where the darkest count most

// The probes that count at a position, in the order of ProbesAround's corners.
struct ProbeWeights {
  uint32_t probe[8] = {};
  float weight[8] = {};  // of the first `count`: in [kLeastWeight, 1]; not normalised, in free space they sum to 1
  int count = 0;         // 0 … 8
  // In [0, 1]: what normalised weights sum to. Below 1 where all probes have hardly more than the residue of their tents; the darkest probes
  // take the rest.
  float certainty = 1.0f;
};

// The weights of the 8 probes around a position: with v = phi(local) / tent(local), clamped to [0, 1], a weight is tent * tent_ratio *
// max(0, v - kResidue) / (1 - kResidue). Bare tents have v = 1. Probes below kLeastWeight and those of kNoWeight are left out. The certainty
// is the weighted mean of v - kResidue over kResidue, at most 1.
//
// returns   false, *weights unchanged, outside (as ProbeTree::lookUp). True with a count of 0 where no probe has weight: in solid, and at few
//           points in air
bool lookUpWeights(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights);

// The weights of bare tents, whatever the functions say, of all probes but those of kNoWeight. They leak through walls: for callers that
// must light something where lookUpWeights counts none.
// returns   as lookUpWeights; the count is 0 where all probes around are without weight, or the position is that of one of those
bool lookUpTents(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights);

// The same of probes that ProbeTree has found already.
void weightsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights);
void tentsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights);

// Scales weights so that they sum to the certainty: the shares of the blend.
// returns   false, *weights unchanged, when the count is 0
bool normaliseWeights(ProbeWeights* weights);

enum class LightStatus : uint8_t {
  lit,      // by weighting functions
  faint,    // no weight can be believed wholly: what ProbeWeights::certainty lacks is of the darkest probes around
  unlit,    // no probe around has a function, or the grid no light; the result is 0
  outside,  // in no cell, or not finite; light of the nearest used cell within one unit, 0 where there is none
};

// "lit", "faint", "unlit", "outside"
const char* lightStatusName(LightStatus status);

// The shares that the probes around take of the blend: they add up to 1, or to their certainty in a grid without light. A count of
// 0 where there are none.
LightStatus lookUpShares(const LightGrid& grid, const PositionM& position_m, ProbeWeights* shares);

// Radiance that arrives, as spherical harmonics (light_grid.h): the blend of the probes' light.
//
// grid         one that checkLightGrid accepts. One without light is unlit everywhere inside
// light_9x3    kShFloats floats, overwritten; all 0 where there is no light
LightStatus lookUpLight(const LightGrid& grid, const PositionM& position_m, float* light_9x3);

// Irradiance on a plane: what a diffuse surface multiplies by its albedo over pi. No channel is below 0.
//
// normal_3   length 1. One with a component that is not finite, or beyond ±kMaxNormal, is no direction: rgb is 0, the status unlit
// rgb_3      3 floats, overwritten
LightStatus lookUpIrradiance(const LightGrid& grid, const PositionM& position_m, const float* normal_3, float* rgb_3);

inline constexpr float kMaxNormal = 1.5f;  // a component of a direction, generously: no rounding of length 1 reaches it
inline bool isDirection(const float* normal_3) {
  // as the comparison is written, NaN is none
  return std::abs(normal_3[0]) <= kMaxNormal && std::abs(normal_3[1]) <= kMaxNormal && std::abs(normal_3[2]) <= kMaxNormal;
}

// Working memory of lookUpIrradiances, 1.3 MB: for any grid, for one thread at a time.
class LookUpScratch {
 public:
  LookUpScratch();
  ~LookUpScratch();
  LookUpScratch(LookUpScratch&&) noexcept;
  LookUpScratch& operator=(LookUpScratch&&) noexcept;

  struct Buffers;  // look_up_batch.cpp
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

// lookUpIrradiance of many positions at once, on vectors: several times faster where many of them share a cell, and faster still where
// these stand side by side in the list. The list changes no bit of a position's result on one SIMD target. Between targets, and
// between this and lookUpIrradiance, results differ by rounding. Allocates nothing, cannot fail.
//
// positions_m   count of them
// normals_3     3 floats each
// rgb_3         3 floats each, overwritten
// status        count of them, overwritten
void lookUpIrradiances(const LightGrid& grid, const PositionM* positions_m, const float* normals_3, size_t count, float* rgb_3,
                       LightStatus* status, LookUpScratch* scratch);

// With a scratch of its own, for a caller that does not mind the allocation.
void lookUpIrradiances(const LightGrid& grid, const PositionM* positions_m, const float* normals_3, size_t count, float* rgb_3,
                       LightStatus* status);

// The same of radiance, as lookUpLight gives it: kShFloats floats a position.
void lookUpLights(const LightGrid& grid, const PositionM* positions_m, size_t count, float* light_9x3, LightStatus* status,
                  LookUpScratch* scratch);

// Light resampled into a dense box: what a shader reads from 3-D textures, without the tree, the functions and their weights.
//
// As the talk does it at run time around the camera; here for any box, once. What lies between two texels is the renderer's own
// interpolation, which no function stops at walls: boxes want texels much smaller than the walls are thick, or a field of them.

// Texels along each axis of a box; their centres lie half a texel inside its faces, as a sampler has them.
struct LightBox {
  PositionM low_m{}, high_m{};            // world, metres; finite
  std::array<uint32_t, 3> texel_count{};  // x, y, z

  size_t texelCount() const { return size_t{texel_count[0]} * texel_count[1] * texel_count[2]; }
  PositionM texelCentre(size_t x, size_t y, size_t z) const;
};

// x is the fastest index, z the slowest.
struct ResampledLight {
  std::vector<float> light;         // kShFloats a texel: radiance as spherical harmonics; 0 where there is none
  std::vector<LightStatus> status;  // by texel: who shows it fills what is faint, unlit or outside as it likes
};

// lookUpLight at the centre of every texel, by vectors. Allocates the result, 109 bytes a texel.
ResampledLight resampleLight(const LightGrid& grid, const LightBox& box, LookUpScratch* scratch);

}  // namespace nlg
