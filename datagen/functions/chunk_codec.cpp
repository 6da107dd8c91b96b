#include "datagen/functions/chunk_codec.h"

#include <libdeflate.h>

#include <algorithm>
#include <memory>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kChecksumBytes = 4;

libdeflate_compressor* compressor() {
  thread_local const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> owner(
      libdeflate_alloc_compressor(kDeflateLevel), libdeflate_free_compressor);
  NLG_CHECK(owner != nullptr, ==, true);
  return owner.get();
}

libdeflate_decompressor* decompressor() {
  thread_local const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> owner(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  NLG_CHECK(owner != nullptr, ==, true);
  return owner.get();
}

}  // namespace

uint32_t fletcher32(const uint8_t* bytes, size_t count) {
  // so many words fit before the second sum can overflow (H5checksum.c, after Fletcher 1982)
  constexpr size_t kRun = 360;
  uint32_t sum1 = 0, sum2 = 0;
  const auto fold = [](uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
  // sums are folded, not divided: adding the carry back keeps them modulo 65535
  for (size_t words = count / 2; words > 0;) {
    const size_t run = std::min(words, kRun);
    words -= run;
    for (size_t i = 0; i < run; ++i, bytes += 2) {
      sum1 += static_cast<uint32_t>(bytes[0]) << 8 | bytes[1];
      sum2 += sum1;
    }
    sum1 = fold(sum1);
    sum2 = fold(sum2);
  }
  // an odd last byte counts as the high half of a word
  if (count % 2 != 0) {
    sum1 += static_cast<uint32_t>(*bytes) << 8;
    sum2 += sum1;
    sum1 = fold(sum1);
    sum2 = fold(sum2);
  }
  return fold(sum2) << 16 | fold(sum1);
}

std::vector<uint8_t> encodeChunk(const uint8_t* bytes, size_t count) {
  std::vector<uint8_t> encoded(libdeflate_zlib_compress_bound(compressor(), count) + kChecksumBytes);
  const size_t stream = libdeflate_zlib_compress(compressor(), bytes, count, encoded.data(), encoded.size() - kChecksumBytes);
  NLG_CHECK(stream, >, 0u);
  const uint32_t checksum = fletcher32(encoded.data(), stream);
  for (size_t i = 0; i < kChecksumBytes; ++i) encoded[stream + i] = static_cast<uint8_t>(checksum >> 8 * i);
  encoded.resize(stream + kChecksumBytes);
  return encoded;
}

bool decodeChunk(const uint8_t* encoded, size_t encoded_count, uint8_t* bytes, size_t count) {
  if (encoded_count <= kChecksumBytes) return false;
  const size_t stream = encoded_count - kChecksumBytes;
  uint32_t stored = 0;
  for (size_t i = 0; i < kChecksumBytes; ++i) stored |= static_cast<uint32_t>(encoded[stream + i]) << 8 * i;
  if (fletcher32(encoded, stream) != stored) return false;
  return libdeflate_zlib_decompress(decompressor(), encoded, stream, bytes, count, nullptr) == LIBDEFLATE_SUCCESS;
}

}  // namespace nlg
