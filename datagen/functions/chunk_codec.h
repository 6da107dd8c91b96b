// Codec of one chunk of an HDF5 array: HDF5's own filters deflate and Fletcher-32, computed here because HDF5's library is
// single-threaded and has a slower deflate. Every HDF5 tool reads what these functions write.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlg {

// libdeflate's level of encodeChunk, also told to HDF5. Measured on shards of levels (docs/lab/measurements.md): level 5 saves 4 %
// of the bytes and costs a third of the speed.
inline constexpr int kDeflateLevel = 1;

// The checksum of HDF5's filter of that name: big-endian 16-bit words, an odd last byte is the upper half of one.
uint32_t fletcher32(const uint8_t* bytes, size_t count);

// A zlib stream followed by its Fletcher-32, little-endian. The same bytes give the same result on every machine and thread.
std::vector<uint8_t> encodeChunk(const uint8_t* bytes, size_t count);

// The inverse; false when the checksum does not fit, or the stream is damaged or does not hold exactly `count` bytes.
bool decodeChunk(const uint8_t* encoded, size_t encoded_count, uint8_t* bytes, size_t count);

}  // namespace nlg
