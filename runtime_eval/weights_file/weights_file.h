// Reads and writes the file of an exported generator (safetensors).
//
// Layout (https://github.com/huggingface/safetensors): 8 bytes little-endian header length, a JSON header that maps names to
// dtype, shape and byte range, then the raw little-endian tensors. Here every tensor is F32 or F16 and starts at a multiple of 64
// bytes of the file, and `__metadata__` holds text. The standard allows no holes between tensors, so filler tensors of dtype U8 named
// "padding.0", "padding.1", … stand where bytes are skipped, and spaces at the end of the header: other tools read these files
// as they are. Readers check fillers like any tensor, then forget them. No exceptions (compiles with -fno-exceptions), no
// dependency: an engine links this. What the names mean: docs/reference/formats.md.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "nlg/result.h"

namespace nlg {

// How a tensor's numbers lie in the file; in memory they are floats.
enum class WeightsDtype { float32, float16 };

struct WeightsTensor {
  std::vector<uint64_t> shape;  // at most 4 dimensions
  std::vector<float> values;    // row-major; all finite
  WeightsDtype dtype = WeightsDtype::float32;
};

struct WeightsFile {
  std::map<std::string, WeightsTensor> tensors;
  std::map<std::string, std::string> metadata;  // but for the digest, which belongs to the bytes
};

// Reads a file, or bytes in memory. A generator's file, which says its version, must name its digest. The digest is compared with the
// file's bytes before anything else is believed. Every offset is checked against the size before it is followed; nothing is allocated
// that the bytes do not cover (F16 takes twice its bytes), and a file is never in memory twice. On failure *file is left empty.
FileResult readWeightsFile(const std::string& path, WeightsFile* file);
FileResult parseWeights(std::string_view bytes, WeightsFile* file);

// Rounds a tensor's values to float16 (to nearest, ties to even) and has it stored so: what a reader of the file gets is what
// *tensor then holds.
// returns   value_out_of_range, *tensor unchanged, when a value is beyond float16
FileResult roundToFloat16(const std::string& name, WeightsTensor* tensor);

// The bytes of a file: tensors in the order of their names; the same content gives the same bytes.
//
// file   names and texts in UTF-8; no metadata key is "file_sha256", which is written here; no tensor is named "__metadata__" or "padding.…"; values as many as the shape says; those of
//        F16 tensors are float16's own (roundToFloat16)
std::string serializeWeights(const WeightsFile& file);

}  // namespace nlg
