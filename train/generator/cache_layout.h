// Layout of a function cache, shared by its reader and writer (docs/reference/formats.md, "Function cache").
#pragma once

#include <cstdint>

#include "nlg/support.h"

namespace nlg {

inline constexpr char kCacheMagic[8] = {'n', 'l', 'g', 'c', 'a', 'c', 'h', 'e'};
inline constexpr uint64_t kCacheVersion = 2;
inline constexpr size_t kFirstRecord = 4096;  // a page: records begin on one

// The first bytes of the file; zeros up to kFirstRecord. Little-endian, as everything in the file.
struct CacheHead {
  char magic[8];
  uint64_t version;
  uint64_t footer_first;   // byte where the footer begins; it ends with the file
  char footer_sha256[64];  // hexadecimal
};

// phi, validity, sums of the blend, coefficients
inline constexpr size_t recordBytes(int coefficient_count) {
  return 2 * kSupportPointCount + kValidityByteCount + sizeof(float) * static_cast<size_t>(coefficient_count);
}

}  // namespace nlg
