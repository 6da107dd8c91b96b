#include "tests/fuzz/digests.h"

#include <cstdint>
#include <cstring>

#include "runtime_eval/weights_file/header_parser.h"
#include "runtime_eval/weights_file/sha256.h"

namespace nlg::fuzz {
namespace {

constexpr size_t kLengthBytes = 8, kDigits = 64;

}  // namespace

std::string withRightDigest(std::string safetensors) {
  uint64_t length = 0;
  if (safetensors.size() < kLengthBytes || safetensors.size() % 16 == 0) return safetensors;
  std::memcpy(&length, safetensors.data(), kLengthBytes);
  if (length > safetensors.size() - kLengthBytes) return safetensors;
  WeightsHeader header;
  if (!parseWeightsHeader(std::string_view(safetensors).substr(kLengthBytes, length), &header).empty()) return safetensors;
  if (header.digest_offset == 0 || safetensors.size() - kLengthBytes - header.digest_offset < kDigits) return safetensors;
  safetensors.replace(kLengthBytes + header.digest_offset, kDigits, std::string(kDigits, '0'));
  Sha256 hash;
  hash.add(safetensors.data(), safetensors.size());
  return safetensors.replace(kLengthBytes + header.digest_offset, kDigits, hexadecimal(hash.finish()));
}

}  // namespace nlg::fuzz
