// A light grid as shaders read it: one array of 32-bit words, for look_up.glsl.
//
// From a position to the eight probes around it are two reads, one behind the other: a dense table of blocks of 4 units names the
// brick that a position is in, and the brick's slots name probes. Probes are numbered class by class: those of each
// representation, those of bare tents, those without weight. A class has records of one stride, so that a probe's number alone
// says where its record is and whether it has a network at all:
//
//     words 0 …      light: a record of PackedLight, 1 to 8 words; of grids with groups of light one of each group, the second
//                    and later ones from the next 16 bytes on
//     then           theta, of classes with functions, from the next 16 bytes on; of codes one word, the next one, which names a
//                    brick and its step
//
// theta of networks stands in fours of numbers, layer by layer, a column of each layer's matrix after the other, so that a layer is
// multiply-adds of vectors: hidden layers in bytes where theta was rounded to int8, otherwise in float16, the last layer in
// float16. Nodes of product fields are pairs of float16. Records begin at multiples of 16 bytes; what a record leaves is 0.
//
// A code is not there, but its brick, once for all probes that share the function: behind the records, in the order of the probes that
// have them, in the words of LightGrid::quads, of which a look-up reads two that lie side by side. The record's word: a quarter of the
// brick's first word in bits 0 … 26, above it e + 4, where a step is 2^e logits.
//
// The head, 16 bytes each:
//
//     0             first_m x, y, z, units a metre                      float
//     1             first block x, y, z; first word of the blocks       int
//     2             blocks along x, y, z; first word of the slots       int
//     3             scale of light (float), classes; the first 8 bytes of the SHA-256 of all words, these two taken as zeros
//     4             axes of light, bits of a record's scale, words of a record of light; groups of light, 0 where all is one
//     5 + 2 k       of class k: first probe, first record, its stride (the last two in units of 16 bytes), kind and flags
//     6 + 2 k       slope, 0, step of bytes (float); nodes along an edge of a product field or brick
//
// and behind all classes 7 of each axis of light, floats times the light's unit over the grid's scale, a power of two: red's coefficients 1 to 4, 5 to 8, those of green,
// those of blue, then the three coefficients 0 and, an int, where the axis's number stands: its word, shift << 3, bits << 8, offset << 16.
// Behind the axes stands of each group the colour that its light is multiplied by, floats, startingColours to begin with: engines write others.
//
// A block: first slot in bits 0 … 26, log2 of its brick's cells along an edge in 27, 28, log2 of a cell's side above; 0xffffffff
// without a cell. A slot: the probe in bits 0 … 26, log2 of its spacing (units) in 27 … 29; bit 31: the cell above is used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "nlg/light_grid.h"

namespace nlg {

struct ShaderGrid {
  std::vector<uint32_t> words;       // a multiple of 4 of them
  std::vector<std::string> defines;  // what look_up.glsl is to be compiled for: NLG_NETWORK_4, NLG_CLASS_COUNT 3, …
  int header_count = 0;              // of 16 bytes, at the beginning
  int first_colour = 0;              // of them: the colour of the first group of light; 0 without groups
  std::vector<std::string> groups;   // names of the groups of light; none: all is one
  size_t tree_bytes = 0, light_bytes = 0, theta_bytes = 0;
  std::vector<uint32_t>
      probe_record;         // by probe: the uvec4 of its light, as look_up.glsl's NlgShares names it; 0 of those without
  size_t light_read = 0;    // bytes that a pixel reads of a probe's light
  size_t largest_read = 0;  // bytes that it reads at most of one probe: light, and what it reads of the largest function
};

// What theta and light become here beside the grid: nothing, for a grid read from a file with theta in int8.
// Other theta are rounded to float16, but for codes, whose bricks are the grid's own; light that is not packed yet is packed with kLightError.
//
// grid      one that checkLightGrid accepts
// returns   ok; or value_out_of_range and what is wrong: a grid without light, a theta beyond float16, more than 2^27 slots,
//           2^29 words or kMaxShaderBlocks blocks, a brick with steps of more than 2^27 logits, a cornerError above kMostCornerError
//           of the spacing. *shader_grid is empty then
FileResult packShaderGrid(const LightGrid& grid, ShaderGrid* shader_grid);

// Metres by which first_m, as float, lies off along an axis at most: far from the world's origin a grid is to be moved before it is
// packed (ProbeTree::moveBy), and positions with it.
double cornerErrorM(const ProbeTreeFrame& frame);
inline constexpr double kMostCornerError = 1.0 / 64.0;

inline constexpr uint64_t kMaxShaderBlocks = 1ull << 26;  // of 4 bytes each: a level a kilometre long at 0.25 m has 6e7

}  // namespace nlg
