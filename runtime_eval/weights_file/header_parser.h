// Parses the JSON header of a safetensors file, strictly by the format.
//
// Schema-driven, so its depth is bounded by its code: an object of tensors, each {"dtype", "shape", "data_offsets"}, and
// `__metadata__`, an object of texts. Refused: repeated or unknown keys, numbers that are no plain unsigned integers, texts that
// are no UTF-8, anything but spaces after the closing brace. Whether ranges and dtypes make sense is for the caller.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace nlg {

constexpr size_t kMaxTensorDimensions = 4;

struct TensorEntry {
  std::string dtype;
  std::vector<uint64_t> shape;  // at most kMaxTensorDimensions
  uint64_t begin = 0, end = 0;  // bytes, relative to the end of the header
};

// A metadata key: the SHA-256 of the whole file with these 64 hexadecimal digits taken as zeros.
inline constexpr const char* kDigestKey = "file_sha256";

struct WeightsHeader {
  std::map<std::string, TensorEntry> tensors;
  std::map<std::string, std::string> metadata;
  size_t digest_offset = 0;  // in the header's text: where the value of kDigestKey begins; 0 without that key
};

// Parses the header's text. Never throws on any bytes (but for lack of memory, and it takes no more than a few times the text's).
// returns   an empty text, or what was expected and where: "byte 17: expected ':'"
std::string parseWeightsHeader(std::string_view text, WeightsHeader* header);

// A text as JSON, in quotes.
std::string jsonQuoted(std::string_view text);

}  // namespace nlg
