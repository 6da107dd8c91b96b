// The light grid, the result of a bake: probes, the weighting function and the light of each; and its file.
//
// Lighting at a position is the normalised sum of the light of the probes around it, weighted by their functions (look_up.h).
// Probes may share a function; probes in free space need none.
#pragma once

#include <algorithm>
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

// Real spherical harmonics up to order 2, and irradiance from them.
//
// Coefficients are those of radiance over the directions that light comes from; a coefficient is the mean over the sphere of
// radiance times basis function, times 4 pi. Order of the 9: Y00, Y1-1 (y), Y10 (z), Y11 (x), Y2-2 (xy), Y2-1 (yz), Y20 (3z²-1),
// Y21 (xz), Y22 (x²-y²). Irradiance by Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment maps"
// (SIGGRAPH 2001): each band times pi, 2 pi / 3, pi / 4.
inline constexpr int kShCount = 9;     // coefficients of order 2
inline constexpr int kShChannels = 3;  // red, green, blue
inline constexpr int kShFloats = kShCount * kShChannels;

// Factor of each coefficient in irradiance, by its band.
inline constexpr std::array<float, kShCount> kCosineBand = {3.14159265f, 2.09439510f, 2.09439510f, 2.09439510f, 0.78539816f,
                                                            0.78539816f, 0.78539816f, 0.78539816f, 0.78539816f};

// Returns the 9 basis functions at a direction of length 1.
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

// Returns irradiance (red, green, blue) on a plane that faces (x, y, z), of length 1. Where light comes from few directions it falls
// below 0: flooredIrradiance is what look-ups return.
//
// light_9x3   kShFloats floats: red, green and blue of each of the 9 coefficients
inline std::array<float, kShChannels> shIrradiance(const float* light_9x3, float x, float y, float z) {
  const std::array<float, kShCount> basis = shBasis(x, y, z);
  std::array<float, kShChannels> rgb{};
  for (int i = 0; i < kShCount; ++i) {
    for (int c = 0; c < kShChannels; ++c) rgb[c] += kCosineBand[i] * basis[i] * light_9x3[i * kShChannels + c];
  }
  return rgb;
}

// Look-ups return at least this share of a channel's mean irradiance over all normals. Harmonics of order 2 fall below 0 beside a
// bright source, each channel at its own normal: cut off at 0, walls have coloured stains. Measured: docs/lab/light.md.
inline constexpr float kIrradianceFloor = 0.1f;

// The same of a channel's coefficient 0, which is its mean over all directions.
inline constexpr float kFloorOfMean = kIrradianceFloor * kCosineBand[0] * 0.28209479f;

// Returns the irradiance that look-ups return: shIrradiance, each channel at least kIrradianceFloor of its mean, and 0.
inline std::array<float, kShChannels> flooredIrradiance(const float* light_9x3, float x, float y, float z) {
  std::array<float, kShChannels> rgb = shIrradiance(light_9x3, x, y, z);
  for (int c = 0; c < kShChannels; ++c) rgb[c] = std::max({rgb[c], kFloorOfMean * light_9x3[c], 0.0f});
  return rgb;
}

// The light of all probes, packed for files and shaders: one record of bits per probe, along principal axes that all probes
// share. How axes and bits are chosen, and how a record is read: docs/reference/formats.md.
struct LightAxis {
  int bits = 0;                                 // of a record's number along this axis: 0 to 12; 0: all probes have the same
  int32_t offset = 0;                           // |offset| <= 2^12
  std::array<uint16_t, kShFloats> direction{};  // float16 bits: red, green and blue of each of the 9 coefficients
};
struct PackedLight {
  float unit = 1.0f;  // > 0
  int scale_bits = 0;
  std::vector<LightAxis> axes;    // at most kShFloats
  std::vector<uint32_t> records;  // of all probes with weight, 1 to 8 words each; unused bits are 0
};
inline constexpr double kLightError = 0.02;  // default limit of the error of packing: relative RMSE of irradiance over all probes

// Values of LightGrid::probe_function that are no index:
inline constexpr uint32_t kFreeSpace = 0xffffffffu;  // the bare tent is enough: nothing stored
inline constexpr uint32_t kNoWeight = 0xfffffffeu;   // the probe lies in solid, or its function is 0 everywhere

inline constexpr size_t kMaxGridFunctions = kNoWeight;
inline constexpr size_t kMaxGridRepresentations = 256;
inline constexpr float kMaxGridTheta = 1e9f;     // limit of |theta|, within which no look-up overflows
inline constexpr float kMaxGridLight = 0x1p30f;  // limit of |light|, likewise
inline constexpr size_t kMaxLightGroups = 16;

// The brick of a function that is a code: its logits at the nodes of a grid, which look-ups read.
struct FunctionBrick {
  uint64_t begin = 0;  // into LightGrid::quads
  float step = 0.0f;   // 0 for functions that are not codes
  int resolution = 0;  // nodes along an axis
};

// A group of light, which an engine can dim, colour or switch.
struct LightGroup {
  std::string name;          // unique, not empty, without control characters
  std::vector<float> light;  // by probe, as LightGrid::light
  bool begins_dark = false;  // true for light states after the first
};

struct LightGrid {
  ProbeTree tree;
  std::vector<uint32_t> probe_function;          // by probe: index of a function, kFreeSpace or kNoWeight
  std::vector<Representation> representations;   // those that functions use
  std::vector<uint8_t> function_representation;  // by function: index into representations
  std::vector<uint64_t> theta_begin{0};  // by function: where its D floats begin in theta; and the size of theta at the end
  std::vector<float> theta;
  // For codes; made from theta by addFunction and makeBricks. Call makeBricks after changing the theta of a code.
  std::vector<FunctionBrick> function_brick;  // by function
  std::vector<uint32_t> quads;                // bricks in the order of functions: four neighbouring nodes a word
  std::vector<float> light;        // by probe: kShFloats each, radiance as spherical harmonics; empty: the grid holds no light
  std::vector<LightGroup> groups;  // empty: light has no groups. Otherwise light is their sum, by mixLight and startingColours
  PackedLight packed_light;        // by probe with weight, group after group

  // Returns kShFloats floats. The grid must have light.
  // probe   < tree.probeCount()
  const float* probeLight(size_t probe) const { return &light[probe * kShFloats]; }
  size_t functionCount() const { return function_representation.size(); }
  // Returns D floats.
  // function   < functionCount()
  const float* functionTheta(size_t function) const { return &theta[theta_begin[function]]; }
  // Adds a function and returns its index.
  // representation   index into representations
  // theta_D          D floats of that representation
  uint32_t addFunction(uint8_t representation, const float* theta_D);
  // Returns the words of a brick.
  // function   one that is a code
  const uint32_t* functionQuads(size_t function) const { return &quads[function_brick[function].begin]; }
  // Removes functions that no probe has, and representations that no function has.
  void dropUnusedFunctions();
  // Computes all bricks. A code whose theta checkLightGrid refuses, or whose dictionary is null, gets none.
  void makeBricks();
};

// Checks that all parts of a grid fit together: sizes, indices, known representations with slopes in (0, 1) or a dictionary,
// |theta| <= kMaxGridTheta, |light| <= kMaxGridLight, and a brick for every code (but not that it matches theta). Look-ups
// require a grid that passes; grids of readLightGridFile do.
// returns   ok; or tensor_unexpected (a size), value_out_of_range or value_not_finite, and one line that says what is wrong
FileResult checkLightGrid(const LightGrid& grid);
// Checks only that |light| <= kMaxGridLight.
FileResult checkLight(const std::vector<float>& light);

// Sets grid->light to the sum of its groups' light, each multiplied by a colour. Costs about 30 multiply-adds per probe and
// group.
//
// colours   one per group: linear factors of red, green and blue, finite, as {1, 0.5, 0.5}
// returns   ok; or the result of checkLight for the sum, and light is unchanged
FileResult mixLight(const std::vector<std::array<float, 3>>& colours, LightGrid* grid);

// Returns the colours that a grid starts with: 1, and 0 for groups that begin dark.
std::vector<std::array<float, 3>> startingColours(const LightGrid& grid);

// Returns the light of each group; without groups, one entry with all light. The grid must outlive it.
std::vector<const std::vector<float>*> lightByGroup(const LightGrid& grid);

// Texts by key, as scene, options, revision and hash of the weights: any UTF-8. Reserved keys: file_sha256, kind, version,
// pattern_hash, light, light_groups, light_groups_dark, representation_count, representation.N, slope.N.
using GridMetadata = std::map<std::string, std::string>;

// Number formats of a file.
struct GridPrecision {
  ThetaPrecision theta = ThetaPrecision::float16;
  // Maximum error of packing, for light that is not packed yet (kLightError). None: the file has no light.
  std::optional<double> light_error = kLightError;
};

// Writes the file of a light grid (safetensors, docs/reference/formats.md) to memory. The same grid, precision and texts give the
// same bytes. float16 rounds every number of theta to the nearest half, ties to even; int8 requires theta that the policy has
// rounded to int8. What no look-up reads is not stored: light of probes without weight (kNoWeight), terms of a dictionary beyond
// its longest code, and its deviations. A reader gets 0, 0 and 1 for them.
//
// grid       one that checkLightGrid accepts; others are refused with its result
// metadata   without reserved keys
// returns    ok; value_out_of_range: |theta| > 65504 with float16, a last layer beyond float16 with int8, packed light beyond
//            kMaxGridLight, a reserved key; header_malformed: a text that is not UTF-8; header_too_large: texts that are too
//            long. The detail names function and value; *bytes is empty then.
FileResult serializeLightGrid(const LightGrid& grid, const GridPrecision& precision, const GridMetadata& metadata,
                              std::string* bytes);

// Reads the file of a light grid, or its bytes, and verifies every byte by a SHA-256. An accepted grid passes checkLightGrid, and
// its tree is one that ProbeTree::build can give, so that no look-up leaves it. Memory is proportional to the file's size,
// whatever its header says.
//
// path      as "level.safetensors"
// returns   ok; otherwise the status and one line that says where and why, and *grid and *metadata are empty
FileResult readLightGridFile(const std::string& path, LightGrid* grid, GridMetadata* metadata);
FileResult parseLightGrid(std::string_view bytes, LightGrid* grid, GridMetadata* metadata);

}  // namespace nlg
