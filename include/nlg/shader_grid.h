// Packs a light grid for shaders: one array of 32-bit words, which look_up.glsl reads.
//
// Two dependent reads lead from a position to the eight probes around it: a dense table of blocks of 4 units gives the brick of
// the position, and the brick's slots give the probes. Probes are numbered class by class: those of each representation, those of
// bare tents, those without weight. The records of a class have one stride, so that a probe's number gives the place of its
// record and whether it has a function:
//
//     from word 0    light: a record of PackedLight, 1 to 8 words; in grids with groups of light one per group, the second
//                    and later ones from the next 16 bytes on
//     then           theta, in classes with functions, from the next 16 bytes on; for codes one word, the next one, which gives
//                    a brick and its step
//
// theta of networks is stored in groups of four numbers, layer by layer and column by column of each layer's matrix, so that a
// layer is multiply-adds of vectors. Hidden layers are bytes if theta was rounded to int8, otherwise float16; the last layer is
// float16. Nodes of product fields are pairs of float16. Records begin at multiples of 16 bytes; unused bytes are 0.
//
// Instead of a code its brick is stored, once for all probes that share the function: after the records, in the order of their
// probes, in the words of LightGrid::quads, of which a look-up reads two neighbouring ones. The record's word holds the brick's
// first word / 4 in bits 0 to 26, and above it e + 4, where a step is 2^e logits.
//
// The header, 16 bytes per row:
//
//     0             first_m x, y, z, units a metre                      float
//     1             first block x, y, z; first word of the blocks       int
//     2             blocks along x, y, z; first word of the slots       int
//     3             scale of light (float), classes; the first 8 bytes of the SHA-256 of all words, computed with these two as 0
//     4             axes of light, bits of a record's scale, words of a record of light; groups of light, 0 without groups
//     5 + 2 k       of class k: first probe, first record, its stride (the last two in units of 16 bytes), kind and flags
//                   (NLG_KIND_ and NLG_FLAG_ in runtime_eval/shader_grid/nlg_light_grid.h)
//     6 + 2 k       slope, 0, step of bytes (float); nodes along an edge of a product field or brick
//
// and after all classes 7 rows per axis of light, floats times the light's unit over the grid's scale, a power of two: red's
// coefficients 1 to 4 and 5 to 8, then green's, then blue's, then the three coefficients 0 and an int that locates the axis's
// number: its word, shift << 3, bits << 8, offset << 16. After the axes follows a row per group: the colour that its light is
// multiplied by, floats, at first startingColours. Engines overwrite it.
//
// A block: first slot in bits 0 to 26, log2 of its brick's cells along an edge in 27 and 28, log2 of a cell's side above;
// 0xffffffff without a cell. A slot: the probe in bits 0 to 26, log2 of its spacing (units) in 27 to 29; bit 31: the cell above
// is used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "nlg/light_grid.h"

namespace nlg {

struct ShaderGrid {
  std::vector<uint32_t> words;       // a multiple of 4 of them
  std::vector<std::string> defines;  // with which look_up.glsl must be compiled, as NLG_NETWORK_4 and NLG_CLASS_COUNT 3
  int header_count = 0;              // rows of the header
  int first_colour = 0;              // row of the colour of the first group of light; 0 without groups
  std::vector<std::string> groups;   // names of the groups of light
  size_t tree_bytes = 0, light_bytes = 0, theta_bytes = 0;
  std::vector<uint32_t> probe_record;  // by probe: the row of its light, as in NlgShares of look_up.glsl; 0 without light
  size_t light_read = 0;               // bytes of a probe's light that a pixel reads
  size_t largest_read = 0;             // maximum bytes of a probe that a pixel reads: light and the largest function
};

// Packs a grid. Theta and light of a grid that was read from a file with int8 keep their values. Other theta are rounded to
// float16, except codes, whose bricks are copied; light that is not packed yet is packed with kLightError.
//
// grid          one that checkLightGrid accepts, with light
// shader_grid   overwritten; empty on failure
// returns       ok; or value_out_of_range and one line that says what is wrong: a grid without light, a theta beyond float16,
//               more than 2^27 slots, 2^29 words or kMaxShaderBlocks blocks, a brick with steps of more than 2^27 logits, or a
//               cornerErrorM above kMostCornerError of the spacing
FileResult packShaderGrid(const LightGrid& grid, ShaderGrid* shader_grid);

// Returns the largest error along an axis of first_m as floats, metres. Move a grid that is far from the world's origin before it
// is packed (ProbeTree::moveBy), and look up positions that are moved likewise.
double cornerErrorM(const ProbeTreeFrame& frame);
inline constexpr double kMostCornerError = 1.0 / 64.0;

inline constexpr uint64_t kMaxShaderBlocks = 1ull << 26;  // of 4 bytes each: a level a kilometre long at 0.25 m has 6e7

}  // namespace nlg
