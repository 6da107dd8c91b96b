// The light grid that a bake leaves behind: where probes stand, a weighting function for each of them, and the light at each; its file.
//
// Lighting at a position is the normalised sum over the probes around it, each with the weight that its function gives (look_up.h). Many
// probes share a function; free space has none at all.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nlg/probe_tree.h"
#include "nlg/representation.h"
#include "nlg/result.h"

namespace nlg {

// Real spherical harmonics up to order 2, and what they say of irradiance.
//
// Coefficients are those of radiance over directions that light comes from; a coefficient is the mean over the sphere of radiance
// times basis function, times 4 pi. Order of the 9: Y00, Y1-1 (y), Y10 (z), Y11 (x), Y2-2 (xy), Y2-1 (yz), Y20 (3z²-1),
// Y21 (xz), Y22 (x²-y²). Irradiance by Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment maps"
// (SIGGRAPH 2001): each band times pi, 2 pi / 3, pi / 4.
inline constexpr int kShCount = 9;     // coefficients of order 2
inline constexpr int kShChannels = 3;  // red, green, blue
inline constexpr int kShFloats = kShCount * kShChannels;

// What irradiance takes of each coefficient's band.
inline constexpr std::array<float, kShCount> kCosineBand = {3.14159265f, 2.09439510f, 2.09439510f, 2.09439510f, 0.78539816f,
                                                            0.78539816f, 0.78539816f, 0.78539816f, 0.78539816f};

// The basis functions at a direction of length 1.
constexpr std::array<float, kShCount> shBasis(float x, float y, float z) {
  return {0.28209479f,
          0.48860251f * y,
          0.48860251f * z,
          0.48860251f * x,
          1.09254843f * x * y,
          1.09254843f * y * z,
          0.31539157f * (3.0f * z * z - 1.0f),
          1.09254843f * x * z,
          0.54627422f * (x * x - y * y)};
}

// Irradiance on a plane that faces (x, y, z), length 1, from coefficients: 9 of red, green, blue each. It may fall below 0 where
// light is harsh: whoever shows it clamps it.
inline std::array<float, kShChannels> shIrradiance(const float* light_9x3, float x, float y, float z) {
  const std::array<float, kShCount> basis = shBasis(x, y, z);
  std::array<float, kShChannels> rgb{};
  for (int i = 0; i < kShCount; ++i) {
    for (int c = 0; c < kShChannels; ++c) rgb[c] += kCosineBand[i] * basis[i] * light_9x3[i * kShChannels + c];
  }
  return rgb;
}

// The light of all probes as files and shaders hold it: a record of bits a probe along the principal axes that all of them share. How axes
// and bits are chosen, and how a record is read: docs/reference/formats.md.
struct LightAxis {
  int bits = 0;                                 // of a record's number along this axis: 0 … 12; 0 where all probes share it
  int32_t offset = 0;                           // |offset| <= 2^12
  std::array<uint16_t, kShFloats> direction{};  // float16 bits: 9 of red, green and blue each
};
struct PackedLight {
  float unit = 1.0f;  // > 0
  int scale_bits = 0;
  std::vector<LightAxis> axes;    // at most kShFloats
  std::vector<uint32_t> records;  // of all probes with weight, 1 to 8 words each; unused bits are 0
};
inline constexpr double kLightError = 0.02;  // what packing may change of irradiance by default: relative RMSE over all probes

// Values of LightGrid::probe_function that are no index:
inline constexpr uint32_t kFreeSpace = 0xffffffffu;  // the bare tent is enough: nothing stored
inline constexpr uint32_t kNoWeight = 0xfffffffeu;   // the probe lies in solid, or its function is 0 everywhere

inline constexpr size_t kMaxGridFunctions = kNoWeight;
inline constexpr size_t kMaxGridRepresentations = 256;
inline constexpr float kMaxGridTheta = 1e9f;     // of |theta|: no look-up overflows below it
inline constexpr float kMaxGridLight = 0x1p30f;  // of |light|: likewise
inline constexpr size_t kMaxLightGroups = 16;

// What a look-up reads of a function that is a code: its logits at the nodes of a grid, the *brick*.
struct FunctionBrick {
  uint64_t begin = 0;  // into LightGrid::quads
  float step = 0.0f;   // 0 of functions that are no codes
  int resolution = 0;  // nodes along an axis
};

// Light that an engine may dim, colour or switch apart from the rest.
struct LightGroup {
  std::string name;          // unique, not empty, without control characters
  std::vector<float> light;  // by probe, as LightGrid::light
  bool begins_dark = false;  // of all states of the level's light but the first
};

struct LightGrid {
  ProbeTree tree;
  std::vector<uint32_t> probe_function;          // by probe: index of a function, kFreeSpace or kNoWeight
  std::vector<Representation> representations;   // those that functions use
  std::vector<uint8_t> function_representation;  // by function: index into representations
  std::vector<uint64_t> theta_begin{0};  // by function: where its D floats begin in theta; and the size of theta at the end
  std::vector<float> theta;
  // Of codes. addFunction and makeBricks make them of theta; whoever changes the theta of a code calls makeBricks.
  std::vector<FunctionBrick> function_brick;  // by function
  std::vector<uint32_t> quads;                // bricks in the order of functions: four neighbouring nodes a word
  std::vector<float> light;        // by probe: kShFloats each, radiance as spherical harmonics; empty: the grid holds no light
  std::vector<LightGroup> groups;  // empty: light is one. Otherwise mixLight makes light of them, with startingColours at first
  PackedLight packed_light;        // by probe with weight, group after group

  // kShFloats floats. probe   < tree.probeCount(); of grids with light
  const float* probeLight(size_t probe) const { return &light[probe * kShFloats]; }
  size_t functionCount() const { return function_representation.size(); }
  // D floats. function   < functionCount()
  const float* functionTheta(size_t function) const { return &theta[theta_begin[function]]; }
  // Adds a function and returns its index.
  // representation   index into representations
  // theta_D          D floats of that representation
  uint32_t addFunction(uint8_t representation, const float* theta_D);
  // The words of its brick. function   of a code
  const uint32_t* functionQuads(size_t function) const { return &quads[function_brick[function].begin]; }
  // Removes functions that no probe has, and representations that no function has.
  void dropUnusedFunctions();
  // Makes all bricks anew. A code whose theta checkLightGrid refuses, or whose dictionary is null, gets none.
  void makeBricks();
};

// Checks that all parts belong together: sizes, indices, known representations with slopes in (0, 1) or a dictionary, |theta| <=
// kMaxGridTheta, |light| <= kMaxGridLight, and a brick for every code (not whether it is that of its theta). Look-ups are for grids that
// pass; what readLightGridFile accepts has passed.
// returns   ok; or tensor_unexpected (a size), value_out_of_range, value_not_finite, and in one line what is wrong
FileResult checkLightGrid(const LightGrid& grid);
// Checks light alone: |light| <= kMaxGridLight.
FileResult checkLight(const std::vector<float>& light);

// Sets grid->light to the sum of its groups' light, each multiplied by a colour. Costs about 30 multiply-adds a probe and group.
//
// colours   as many as groups, linear factors for red, green and blue, finite
// returns   ok; or what checkLight says of the sum, and light is unchanged
FileResult mixLight(const std::vector<std::array<float, 3>>& colours, LightGrid* grid);

// The colours of a grid that was just read: 1, and 0 for groups that begin dark.
std::vector<std::array<float, 3>> startingColours(const LightGrid& grid);

// The light of each group; of a grid without groups, all of it. The grid must outlive it.
std::vector<const std::vector<float>*> lightByGroup(const LightGrid& grid);

// Texts for people, by key: scene, options, revision, hash of the weights. Any UTF-8; these keys are the file's own: file_sha256, kind,
// version, pattern_hash, light, light_groups, representation_count, representation.N, slope.N.
using GridMetadata = std::map<std::string, std::string>;

// What numbers become in a file.
struct GridPrecision {
  ThetaPrecision theta = ThetaPrecision::float16;
  // Error that packing may leave in light that was not packed before (kLightError). None: light is left out.
  std::optional<double> light_error = kLightError;
};

// Writes a light grid's file, safetensors (docs/reference/formats.md), to memory. The same grid, precision and texts give the same bytes.
// float16 rounds every number of theta to the nearest half, ties to even; int8 is for theta that the policy has rounded to int8. Left out,
// since no look-up reads them: light of probes without weight (kNoWeight), the terms of a dictionary beyond its longest code, and its
// deviations; a reader gets 0, 0 and 1.
//
// grid      one that checkLightGrid accepts; others are refused with its result
// returns   ok; value_out_of_range: |theta| > 65504 with float16, a last layer beyond float16 with int8, light that packing takes beyond
//           kMaxGridLight, one of the file's own keys in metadata; header_malformed: a text that is no UTF-8; header_too_large: texts that
//           are too long. The detail names function and value; *bytes is empty then.
FileResult serializeLightGrid(const LightGrid& grid, const GridPrecision& precision, const GridMetadata& metadata,
                              std::string* bytes);

// Reads a light grid's file, or its bytes. A SHA-256 covers every byte. What is accepted passes checkLightGrid, and its tree is one that
// ProbeTree::build gives: no look-up can leave it. Memory is in proportion to the bytes that are there, whatever their header says.
// returns   ok; otherwise one line of detail that says where and why, and *grid and *metadata are empty
FileResult readLightGridFile(const std::string& path, LightGrid* grid, GridMetadata* metadata);
FileResult parseLightGrid(std::string_view bytes, LightGrid* grid, GridMetadata* metadata);

}  // namespace nlg
