// Reads a shard piece by piece, so that it need not fit in memory.
#pragma once

#include <cstdint>
#include <string>

#include "datagen/dataset/hdf5_file.h"
#include "datagen/dataset/shard.h"

namespace nlg {

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
  uint64_t storedBytes() const;  // of all arrays, compressed

 private:
  Hdf5Reader file_;
  Shard header_;
};

}  // namespace nlg
