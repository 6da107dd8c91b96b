// Morton codes of lattice points: interleaved bits of x, y and z, by which the lattice is sorted cube by cube.
#pragma once

#include <array>
#include <cstdint>

namespace nlg {

// Bit i of value moves to bit 3 i. value < 2^21
inline uint64_t spreadBits(uint64_t value) {
  value = (value | value << 32) & 0x001f00000000ffffu;
  value = (value | value << 16) & 0x001f0000ff0000ffu;
  value = (value | value << 8) & 0x100f00f00f00f00fu;
  value = (value | value << 4) & 0x10c30c30c30c30c3u;
  return (value | value << 2) & 0x1249249249249249u;
}

// The inverse: gathers bits 0, 3, 6, …
inline uint64_t gatherBits(uint64_t code) {
  code &= 0x1249249249249249u;
  code = (code | code >> 2) & 0x10c30c30c30c30c3u;
  code = (code | code >> 4) & 0x100f00f00f00f00fu;
  code = (code | code >> 8) & 0x001f0000ff0000ffu;
  code = (code | code >> 16) & 0x001f00000000ffffu;
  return (code | code >> 32) & 0x1fffffu;
}

// Coordinates in [0, 2^21).
inline uint64_t mortonFromLattice(const std::array<int32_t, 3>& p) {
  return spreadBits(static_cast<uint32_t>(p[0])) | spreadBits(static_cast<uint32_t>(p[1])) << 1 |
         spreadBits(static_cast<uint32_t>(p[2])) << 2;
}
inline std::array<int32_t, 3> latticeFromMorton(uint64_t code) {
  return {static_cast<int32_t>(gatherBits(code)), static_cast<int32_t>(gatherBits(code >> 1)),
          static_cast<int32_t>(gatherBits(code >> 2))};
}

}  // namespace nlg
