// Packs the light of a grid's probes for files and shaders.
//
// A level's light has few dimensions: the 27 numbers of a probe, divided by their length, lie near a plane that the level itself gives
// (the principal axes of all its probes' light). A probe is a record of bits, all of one layout:
//
//     light = unit * 2^(s / 16) * sum over k of (u_k + offset_k) * axis_k          s > 0; s = 0 is darkness
//
// s and the u_k are unsigned numbers of so many bits each, s first. Each stands in the next bits of the record's current word of 32 bits,
// lowest first, or where it does not fit there begins the next word: so shaders read them. How many axes there are, and how many bits
// each gets, is chosen by the error that a caller accepts: some 16 bytes a probe, where 27 float16 are 54. A file takes half of that
// (light_records.h).
//
// Errors are those of irradiance, root mean square over all normals and channels, over the irradiance of the same probe by the same
// measure: a dark room counts as much as a terrace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nlg/light_grid.h"
#include "runtime_eval/numbers/half.h"

namespace nlg {

inline constexpr int kMaxLightWords = 8;   // of 32 bits, a record
inline constexpr int kMostScaleBits = 11;  // of s: 128 octaves
inline constexpr int kMostAxisBits = 12;   // of u_k
inline constexpr int kScalesAnOctave = 16;
inline constexpr double kLeastLightError = 1e-3, kMostLightError = 0.5;  // what may be asked for

// Where a number stands in a record; in no place where it has no bits.
struct LightField {
  int word = 0, shift = 0, bits = 0;
};
// Of s, then of every u_k.
std::vector<LightField> lightFields(const PackedLight& packed);
// Words of 32 bits a record.
int lightWords(const PackedLight& packed);

inline uint32_t lightNumber(const uint32_t* record, const LightField& field) {
  return record[field.word] >> field.shift & ((1u << field.bits) - 1);
}
// Of all but the records.
// returns   ok; tensor_unexpected, value_out_of_range, value_not_finite; value_out_of_range and more than kMaxLightWords
FileResult checkLightLayout(const PackedLight& packed);

// What packing leaves of light.
struct LightPacking {
  double error = 0.0;   // root mean square over all probes that are lit
  double worst = 0.0;   // of a probe
  size_t too_dark = 0;  // probes below 2^-40 of the brightest, or 1e-30: dark from here on
};

// The shortest record whose error is at most max_error, and the largest steps that it allows; or the longest record there is, where that
// does not reach it.
//
// light      kShFloats floats a probe, finite, |light| <= kMaxGridLight (light_grid.h)
// max_error  kLeastLightError … kMostLightError
LightPacking packLight(const std::vector<float>& light, double max_error, PackedLight* packed);

// What a file held, checked: sizes against the probes, numbers finite and in range. The same floats on every machine.
// light     of each group, by probe: 0 without weight
// returns   ok; tensor_unexpected (a size), value_not_finite or value_out_of_range, with one line that says where; *light is
//           empty then
FileResult unpackGridLight(const PackedLight& packed, const std::vector<uint32_t>& probe_function, size_t group_count,
                           std::vector<std::vector<float>>* light);

inline constexpr float kMaxEngineLight = 32768.0f;  // of |light| that half floats of engines hold: irradiance over pi fits, too

// The power of ten by which light is multiplied to be at most kMaxEngineLight. largest   > 0
double intensityThatFits(double largest);

// Light, of each group and mixed by startingColours, becomes what packed_light holds of it.
// returns   as unpackGridLight; or what checkLight says of it
FileResult takePackedLight(LightGrid* grid);
// Light becomes what a file holds of it: packed_light, with an error that packed_light.h speaks of, and 0 at probes without weight.
LightPacking roundGridLight(double max_error, LightGrid* grid);
// Whether packed_light says what `light`, or its groups, are.
bool holdsPackedLight(const LightGrid& grid);
// packed_light where the grid holds it, and light packed anew otherwise: what files and shaders take.
PackedLight packedLightOf(const LightGrid& grid, double max_error);

}  // namespace nlg
