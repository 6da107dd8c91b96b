// The light grid that a bake leaves behind: where probes stand, a weighting function for each of them, and the light at each.
//
// Lighting at a position is the normalised sum over the probes around it, each with the weight that the look-up gives. Many
// probes share a function; free space has none at all. Only a compiler is needed to look up: irradiance.h gives the blended light;
// light_grid_file.h reads and writes grids.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime_eval/evaluator/representation.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/light_grid/probe_tree.h"
#include "runtime_eval/light_grid/spherical_harmonics.h"
#include "runtime_eval/weights_file/file_result.h"

namespace nlg {

// Instead of a function's index:
inline constexpr uint32_t kFreeSpace = 0xffffffffu;  // the bare tent, exactly or all but: nothing stored
inline constexpr uint32_t kNoWeight = 0xfffffffeu;   // the probe lies in solid, or its function is 0 everywhere

inline constexpr size_t kMaxGridFunctions = kNoWeight;
inline constexpr size_t kMaxGridRepresentations = 256;
// A weight below counts as none: what it would add is not seen, and one over a sum of such could overflow.
inline constexpr float kLeastWeight = 1e-6f;
// Of a probe's tent: what a fit may leave where its target is 0, behind walls, and a look-up takes off (docs/theory/probes.md).
inline constexpr float kResidue = 0.05f;
// Of the light around a place: what is added to a probe's own where those with the least light count most (docs/theory/probes.md).
inline constexpr float kDarkestFloor = 0.01f;
inline constexpr float kMaxGridTheta = 1e9f;        // of |theta|: no look-up overflows below it
inline constexpr float kMaxGridLight = 0x1p30f;     // of |light|, likewise
inline constexpr float kMaxEngineLight = 32768.0f;  // of |light| that half floats of engines hold: irradiance over pi fits, too

// The power of ten by which light is multiplied to be at most kMaxEngineLight. largest   > 0
double intensityThatFits(double largest);

// Where look-ups find the brick of a function that is a code: the code itself they never read.
struct FunctionBrick {
  uint64_t begin = 0;  // into LightGrid::quads
  float step = 0.0f;   // 0 of functions that are no codes
  int resolution = 0;  // of its representation
};

// Light that an engine may dim, colour or switch apart from the rest.
struct LightGroup {
  std::string name;          // unlike all others', not empty, without control characters
  std::vector<float> light;  // by probe, as LightGrid::light
  bool begins_dark = false;  // of one of several ways in which the level may be lit: not of the first
};
inline constexpr size_t kMaxLightGroups = 16;

struct LightGrid {
  ProbeTree tree;
  std::vector<uint32_t> probe_function;          // by probe: a function's index, kFreeSpace or kNoWeight
  std::vector<Representation> representations;   // those that functions use
  std::vector<uint8_t> function_representation;  // by function: index into representations
  std::vector<uint64_t> theta_begin{0};          // by function, into theta; functionCount() + 1 numbers, the last is theta's size
  std::vector<float> theta;                      // D floats a function, one after another
  // Made of theta, by addFunction or makeBricks: whoever changes the theta of a code afterwards makes them anew.
  std::vector<FunctionBrick> function_brick;  // by function
  std::vector<uint32_t> quads;                // bricks (brick_quads.h), one after another in the order of functions
  std::vector<float> light;  // by probe: kShFloats each, radiance (spherical_harmonics.h); empty: the grid holds no light
  std::vector<LightGroup>
      groups;  // none: light is one. Otherwise light is what mixLight made of them, by startingColours to begin with
  PackedLight packed_light;  // of the probes with weight, in their order, group after group; see holdsPackedLight

  // kShFloats floats. probe   < probeCount(); of grids with light
  const float* probeLight(size_t probe) const { return &light[probe * kShFloats]; }
  size_t functionCount() const { return function_representation.size(); }
  // D floats. function   < functionCount()
  const float* functionTheta(size_t function) const { return &theta[theta_begin[function]]; }
  // Adds a function and returns its index.
  // representation   index into representations
  // theta_D          D floats of that representation
  uint32_t addFunction(uint8_t representation, const float* theta_D);
  // quadCount words. function   of a code
  const uint32_t* functionQuads(size_t function) const { return &quads[function_brick[function].begin]; }
  // Leaves out functions that no probe has, and representations that no function has.
  void dropUnusedFunctions();
  // All bricks anew, of functions as they are. A code whose theta checkLightGrid refuses, or whose dictionary is not known, has none.
  void makeBricks();
};

// Whether all parts belong together: sizes, indices, known representations with slopes in (0, 1) or a dictionary, |theta| <=
// kMaxGridTheta, |light| <= kMaxGridLight; a brick for every code, which is taken to be that of its theta.
// The look-up is for grids that pass; what light_grid_file.h read has passed.
// returns   ok; or tensor_unexpected (a size), value_out_of_range, value_not_finite, and in one line what is wrong
FileResult checkLightGrid(const LightGrid& grid);
// The same of a grid whose bricks are still to be made.
FileResult checkWithoutBricks(const LightGrid& grid);
// Of some light alone: |light| <= kMaxGridLight.
FileResult checkLight(const std::vector<float>& light);

// Light becomes the sum of its groups' light, each times a colour: look-ups, and all that reads light, see it from then on. Some 30
// multiply-adds a probe and group.
//
// colours   as many as groups, linear factors for red, green and blue, finite
// returns   ok; or what checkLight says of the sum, and light is as it was
FileResult mixLight(const std::vector<std::array<float, 3>>& colours, LightGrid* grid);

// What groups are multiplied by in a grid as it was read: 1, and 0 for those that begin dark.
std::vector<std::array<float, 3>> startingColours(const LightGrid& grid);

// The light of each group; of a grid without groups, all of it. The grid must outlive it.
std::vector<const std::vector<float>*> lightByGroup(const LightGrid& grid);

// Light, of each group and mixed by startingColours, becomes what packed_light holds of it.
// returns   as unpackLight; or what checkLight says of it
FileResult takePackedLight(LightGrid* grid);
// Light becomes what a file holds of it: packed_light, with an error that packed_light.h speaks of, and 0 at probes without weight.
LightPacking roundGridLight(double max_error, LightGrid* grid);
// Whether packed_light says what `light`, or its groups, are.
bool holdsPackedLight(const LightGrid& grid);
// packed_light where the grid holds it, and light packed anew otherwise: what files and shaders take.
PackedLight packedLightOf(const LightGrid& grid, double max_error);
// As packed_light has it, of each group, by probe: 0 without weight.
// returns   as unpackLight
FileResult unpackGridLight(const PackedLight& packed, const std::vector<uint32_t>& probe_function, size_t group_count,
                           std::vector<std::vector<float>>* light);

// The probes that count at a position, in the order of ProbesAround's corners.
struct ProbeWeights {
  uint32_t probe[8] = {};
  float weight[8] = {};  // of the first `count`: in [kLeastWeight, 1]; not normalised, in free space they sum to 1
  int count = 0;         // 0 … 8
  // In [0, 1], what normalised weights add up to: 1 but where all probes have hardly more than the residue of their tents, so that
  // none can be believed. It fades to 0 there, and irradiance.h says what takes the rest.
  float certainty = 1.0f;
};

// The weights of the 8 probes around a position (docs/theory/probes.md). Of v, the function's share of its tent, phi(local) /
// tent(local) clamped to [0, 1], all up to kResidue counts as nothing, and the rest is stretched to [0, 1]; times the tent and its
// tent_ratio it is the weight. Bare tents have v = 1 and keep all of it, and every function, of any representation, fades to 0 at
// the border of its support. Left out are probes whose weight is below kLeastWeight, and those that have none anywhere
// (kNoWeight). The certainty is the weighted mean of what v has above kResidue, over kResidue: 1 where that is 2 kResidue and more.
// Takes no memory, cannot fail; any number of threads may look up in one grid.
//
// returns   false, *weights unchanged, where ProbeTree::lookUp is: outside. True with a count of 0 where no probe has weight: in
//           solid, and at few places in air (irradiance.h says what lights those)
bool lookUpWeights(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights);

// The weights of bare tents, whatever the functions say, of the probes that have any (all but kNoWeight): what a caller may take
// where lookUpWeights counts none and something has to be lit all the same. Nothing stops these at walls.
//
// returns   as lookUpWeights; the count is 0 where all probes around are without weight, or the position stands at one of those
bool lookUpTents(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights);

// The same of probes that ProbeTree has found already.
void weightsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights);
void tentsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights);

// Makes the weights add up to the certainty: the shares that a blend of the probes takes.
// returns   false, *weights unchanged, when the count is 0
bool normaliseWeights(ProbeWeights* weights);

}  // namespace nlg
