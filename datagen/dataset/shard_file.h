// Reads a shard piece by piece, so that it need not fit in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datagen/dataset/hdf5_file.h"
#include "datagen/dataset/shard.h"
#include "tool/output_path.h"

namespace nlg {

extern const OwnFiles kShardFiles;

class ShardReader {
 public:
  // Reads the attributes and checks the shape of every array against them. Arguments and errors as of readShard (shard.h).
  explicit ShardReader(const std::string& path, uint64_t pattern_hash = 0, int point_count = 0);

  // Everything but the arrays.
  const Shard& header() const { return header_; }
  uint64_t functionCount() const { return header_.counts.functions; }

  // Functions [first, first + count), with the header; count may be anything that functionCount leaves room for. Every chunk is held
  // against its Fletcher-32, which takes 0000 for ffff: who reads all functions asks for verifyDigest, too.
  // throws   InputError on damage: checksums, values that break the contract
  Shard read(uint64_t first, uint64_t count) const;

  // Compares every byte of the file with the stored SHA-256.
  // throws   InputError when they differ
  void verifyDigest() const { file_.verifyDigest(); }

 private:
  Hdf5Reader file_;
  Shard header_;
};

// Up to kChunkFunctions functions as they lie in the file.
struct EncodedFunctions {
  uint64_t function_count = 0;
  std::vector<std::vector<uint8_t>> arrays;  // in the order of forEachArray (shard.h)
};

// Compresses functions [first, first + count); 1 <= count <= kChunkFunctions. Any number of threads may do so
// at the same time.
EncodedFunctions encodeFunctions(const FunctionRows& rows, uint64_t first, uint64_t count);

// Piece by piece, so that a shard need not fit in memory.
class ShardWriter {
 public:
  // Creates path: the temporary name of writeAtomically.
  // header   the shard's; its counts and functions are not looked at
  // throws   OutputError, as every function here does when the disk refuses
  ShardWriter(const std::string& path, const Shard& header);

  // All but the last call bring kChunkFunctions functions.
  void append(const EncodedFunctions& functions);
  // Writes what is known only in the end, and the digest of the file. counts.functions must be what was appended.
  void finish(const ShardCounts& counts);

  uint64_t functionCount() const { return function_count_; }
  uint64_t byteCount() const { return byte_count_; }  // of compressed arrays so far

 private:
  Hdf5Writer file_;
  FunctionRows shape_;  // of no functions
  uint64_t function_count_ = 0, byte_count_ = 0;
};

}  // namespace nlg
