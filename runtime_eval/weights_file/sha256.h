// SHA-256 (FIPS 180-4), by which every file of this project is verified.
//
// No dependency, no exceptions, no allocation. x86 processors with the SHA extensions digest about 2 GB a second with them,
// others a fifth of that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace nlg {

using Sha256Digest = std::array<uint8_t, 32>;

class Sha256 {
 public:
  // portable leaves the processor's SHA extensions alone: the same digests, for comparison
  enum class Path { fastest, portable };
  explicit Sha256(Path path = Path::fastest);

  void add(const void* bytes, size_t count);
  // Of all bytes so far. Ends the digest: nothing is added after it.
  Sha256Digest finish();

 private:
  static constexpr size_t kBlockBytes = 64;

  using Compress = void (*)(uint32_t* state, const uint8_t* blocks, size_t block_count);
  Compress compress_;
  std::array<uint32_t, 8> state_;
  std::array<uint8_t, kBlockBytes> block_;  // what is not yet a whole block
  uint64_t byte_count_ = 0;
};

// 64 lower-case hexadecimal digits.
std::string hexadecimal(const Sha256Digest& digest);

}  // namespace nlg
