// Light at a position, out of a light grid: the blend of the probes around it.
//
// The shares of the blend are normalised weights of light_grid.h. Where none of them can be believed, in solid and at the few places
// in air that no probe around knows, the probes around that hold the least light give it, and the status says so
// (docs/theory/probes.md). In no cell at all, the nearest used cell within one unit of the tree lends its light: a position that a
// rounding or a collision put behind the border is not dark. Takes no memory, cannot fail; any number of threads may look up in one
// grid.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "runtime_eval/light_grid/light_grid.h"
#include "runtime_eval/light_grid/spherical_harmonics.h"

namespace nlg {

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

// Radiance that arrives, as spherical harmonics (spherical_harmonics.h): the blend of the probes' light.
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

  struct Buffers;  // irradiance_batch.cpp
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

}  // namespace nlg
