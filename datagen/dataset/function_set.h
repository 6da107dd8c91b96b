// All functions of several shards in memory: what training, export and validation read.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "datagen/dataset/duplicate_bands.h"
#include "datagen/dataset/duplicate_index.h"
#include "datagen/dataset/shard.h"

namespace nlg {

struct FunctionSet : FunctionRows {
  uint64_t pattern_hash = 0;
  uint64_t test_pattern_hash = 0;
  ShardCounts counts;                  // sums over the shards; duplicates include those between shards
  std::vector<std::string> scene_ids;  // distinct scenes
  std::vector<std::string> families;   // of each distinct scene
  std::vector<uint32_t> scene_idx;     // N, into scene_ids
  std::string sha256;                  // of the shards' hashes in the order of the paths: the data set's identity

  // also of a set made by hand, which may lack arrays that its readers do not ask for
  uint64_t functionCount() const { return scene_idx.size(); }
};

// Memory for sketches beyond which duplicates are looked for band by band: 26 million functions.
inline constexpr uint64_t kDuplicateMemoryBytes = uint64_t{4} << 30;

struct DuplicateFilterOptions {
  DuplicateIndex::Fetch earlier;  // gives the samples of the id-th function kept; without it a copy is kept in a file
  uint64_t memory_bytes = kDuplicateMemoryBytes;  // for sketches
};

// Drops from shards what other shards hold already, by the rule that the shards themselves were made with (DuplicateRule).
//
// Exact, as DuplicateIndex says. Of duplicates the first in the order of the shards is kept, as long as the sketches of all functions
// fit in memory (kDuplicateBytesAFunction each), and their deflated samples in the folder for temporary files (TMPDIR), about 1.2 kB a
// function; where they do not, the first in the order of duplicate_bands.h, whose search then reads all shards once beforehand, and
// takes 88 bytes a function more of that folder.
class DuplicateFilter {
 public:
  // shards   the paths, in the order in which removeKnown is given them
  // throws   as findDuplicates (duplicate_bands.h) does
  explicit DuplicateFilter(const std::vector<std::string>& shards, DuplicateFilterOptions options = {});
  ~DuplicateFilter();
  DuplicateFilter(const DuplicateFilter&) = delete;
  DuplicateFilter& operator=(const DuplicateFilter&) = delete;

  // Takes the known functions out of the next shard's arrays, or out of the next rows of the same shard, and moves them from
  // counts.functions to counts.duplicates.
  // throws   InputError when its rule is not that of the first shard, or an earlier shard cannot be read any more
  void removeKnown(Shard* shard);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Adds every count of `from` to `to`.
void addCounts(const ShardCounts& from, ShardCounts* to);

// Reads shards one after another; a function that duplicates one of an earlier shard is dropped and counted.
// throws   InputError as readShard does; when shards disagree in pattern or test points; when paths is empty; UsageError when two
//          shards have the same bytes: the set would have another identity than the same functions given once
FunctionSet readFunctionSet(const std::vector<std::string>& paths, uint64_t pattern_hash, int point_count = 0);

}  // namespace nlg
