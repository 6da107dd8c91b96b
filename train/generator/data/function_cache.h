// A training set as one memory-mapped file, so that sets larger than memory can be trained on.
//
// Made once from shards and a basis (function_cache_writer.h; layout in docs/reference/formats.md). Functions lie in an order shuffled over
// all shards, with everything that training reads of them side by side, so that neighbours make a fair batch and reading runs
// along the disk.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "nlg/support.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// Functions a block: what is read, checked and shuffled as a unit.
inline constexpr int64_t kBlockFunctions = 512;

// What a cache was made of.
struct CacheOrigin {
  std::string basis_sha256;
  std::string training_set_sha256;            // FunctionSet::sha256 of the shards
  std::map<std::string, std::string> scenes;  // id → SHA-256 (FunctionSet::scene_sha256)
};

class FunctionCache {
 public:
  // Maps the file; its functions are read when they are used.
  // throws   InputError when it is missing, of another version or of another pattern; DamageError when it is truncated or damaged
  explicit FunctionCache(const std::string& path);
  ~FunctionCache();
  FunctionCache(const FunctionCache&) = delete;
  FunctionCache& operator=(const FunctionCache&) = delete;

  const std::string& path() const { return path_; }
  const CacheOrigin& origin() const { return origin_; }
  int64_t functionCount() const { return function_count_; }
  int coefficientCount() const { return coefficient_count_; }
  int64_t blockCount() const { return static_cast<int64_t>(block_sha256_.size()); }

  // Good while the cache lives. Whatever loadBlock has not seen yet is read on the spot, unchecked.
  StoredFunction function(int64_t index) const;
  const float* coefficients(int64_t index) const;  // K, standardised, not mirrored
  float tentRmse(int64_t index) const;             // as below: how hard the function is

  // Asks the system to read a block ahead; returns at once.
  void adviseBlock(int64_t block) const;
  // Reads a block into memory, and checks it the first time. Call it from one thread at a time.
  // throws   DamageError when the block's digest is wrong
  void loadBlock(int64_t block);

 private:
  struct Span {
    const uint8_t* first;
    size_t count;
  };
  Span blockSpan(int64_t block) const;
  void readFooter(const std::string& footer);

  std::string path_;
  CacheOrigin origin_;
  int64_t function_count_ = 0;
  int coefficient_count_ = 0;
  std::vector<std::string> block_sha256_;
  std::vector<bool> checked_;
  std::vector<float> tent_rmse_;
  size_t mapped_count_ = 0;  // before mapped_, which sets it
  const uint8_t* mapped_ = nullptr;
};

// Blend RMSE of the bare tent over the valid points of a function, by the policy's defaults; 0 when there are none.
float tentRmse(const StoredFunction& function);

// The order in which a cache holds its functions: entry i is the number, counted over the shards, of the function in place i.
// It depends on count alone. Leaving out every number from some n on gives cacheOrder(n), so that a set which grows at its end
// keeps the order of the functions that it had.
std::vector<uint32_t> cacheOrder(int64_t count);

// Layout of a function cache, shared by its reader and writer (docs/reference/formats.md, "Function cache").
inline constexpr char kCacheMagic[8] = {'n', 'l', 'g', 'c', 'a', 'c', 'h', 'e'};
inline constexpr uint64_t kCacheVersion = 4;
inline constexpr size_t kFirstRecord = 4096;  // a page: records begin on one

// The first bytes of the file; zeros up to kFirstRecord. Little-endian, as everything in the file.
struct CacheHead {
  char magic[8];
  uint64_t version;
  uint64_t footer_first;   // byte where the footer begins; it ends with the file
  char footer_sha256[64];  // hexadecimal
};

// phi, validity, seen, sums of the blend, coefficients
inline constexpr size_t recordBytes(int coefficient_count) {
  return 2 * kSupportPointCount + 2 * kValidityByteCount + sizeof(float) * static_cast<size_t>(coefficient_count);
}

// From now on SIGBUS, by which the system says that a mapped page is no longer there, ends the process with input_error and the one
// line "TOOL: error: PATH: ...", instead of killing it without a word. Whatever was saved before stays. Calls replace each other.
void endWhenPagesVanish(const std::string& tool, const std::string& path);

}  // namespace nlg
