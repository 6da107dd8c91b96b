// The file of a light grid: safetensors, written by nlg-bake, read by engines. What the tensors mean: docs/reference/formats.md.
//
// Neither direction throws; results are those of file_result.h, with one line that says where and why.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "runtime_eval/light_grid/light_grid.h"
#include "runtime_eval/weights_file/file_result.h"

namespace nlg {

// Texts for people, by key: scene, options, revision, hash of the weights. Any UTF-8, but for the keys that the file itself uses:
// file_sha256, kind, version, pattern_hash, light, light_groups, representation_count, representation.N, slope.N.
using GridMetadata = std::map<std::string, std::string>;

// What numbers become in a file.
struct GridPrecision {
  ThetaPrecision theta = ThetaPrecision::float16;
  // Of light that is not packed yet (holdsPackedLight): the error that packing may leave. None leaves light out.
  std::optional<double> light_error = kLightError;
};

// The bytes of a file; the same grid, precision and texts give the same bytes.
// float16 rounds every number of theta to the nearest half, ties to even; theta_form.h says what int8 makes of theta: the errors that
// this adds are the caller's to measure. Light of probes that have no
// weight anywhere (kNoWeight) is not written: no look-up reads it, and a reader finds 0 there. Nor are the terms of a dictionary behind
// the longest code, which a reader finds 0, and what fits alone need of it: a reader finds deviations of 1.
//
// grid      one that checkLightGrid accepts; others are refused with its result
// returns   ok; also refused, all but the last two value_out_of_range: with float16 a |theta| > 65504 (names function and value),
//           with int8 a last layer that comes to lie beyond float16 (names the function), light that
//           packing takes beyond kMaxGridLight, a key of the file's own, texts that are no UTF-8 (header_malformed) or too long
//           (header_too_large). *bytes is empty then.
FileResult serializeLightGrid(const LightGrid& grid, const GridPrecision& precision, const GridMetadata& metadata,
                              std::string* bytes);

// Reads a file, or bytes in memory. The digest vouches for every byte. What is accepted passes checkLightGrid, and its tree is one
// that ProbeTree::build gives: no look-up can leave it. Memory is in proportion to the bytes that are there, whatever they say.
// returns   ok; otherwise *grid and *metadata are empty
FileResult readLightGridFile(const std::string& path, LightGrid* grid, GridMetadata* metadata);
FileResult parseLightGrid(std::string_view bytes, LightGrid* grid, GridMetadata* metadata);

// Where a file's bytes go, without header and fillers.
struct LightGridBytes {
  size_t light = 0;
  size_t theta = 0;
  size_t dictionaries = 0;    // that codes share
  size_t functions = 0;       // which representation each has
  size_t probe_function = 0;  // which function each probe has
  size_t tree = 0;            // where probes stand
  size_t total() const { return light + theta + dictionaries + functions + probe_function + tree; }
};
LightGridBytes lightGridBytes(const LightGrid& grid, const GridPrecision& precision);
// Of packed_light alone: records, axes and what else says how they are read.
size_t packedLightBytes(const LightGrid& grid);

}  // namespace nlg
