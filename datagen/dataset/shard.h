// A shard: the distinct weighting functions of one scene under one jitter, as stored in a data set file.
//
// The on-disk contract, with every attribute, is in docs/reference/training_files.md. N functions, P = 8192 support points in pattern
// order, U points that no fit sees (0 in shards for training).
#pragma once

#include <cstdint>
#include <string>

#include "datagen/functions/duplicate_index.h"
#include "datagen/functions/function_rows.h"

namespace nlg {

// What a file says beside its functions.
struct ShardHeader {
  std::string path;  // of the file that it was read from; empty for one that was made in memory
  std::string scene_id;
  std::string family;  // procedural family, or "level"
  uint64_t jitter = 0;
  uint64_t pattern_hash = 0;  // of the support pattern: SupportPattern::hash
  uint64_t test_pattern_hash = 0;
  ShardCounts counts;
  DuplicateRule duplicate_rule;  // that no two of its functions satisfy
  std::string provenance_json;   // tool/provenance.h

  // Of the scene as it was read, without regard to its name: a copy has the same. Empty for a procedural scene.
  std::string sceneSha256() const;
};

// All of it; without functions where only the rest and the numbers of points are asked for.
struct Shard : ShardHeader, FunctionRows {};

// Distinct functions a visited probe: the stored ones, and free space as one more when there is any, over all probes that were
// looked at, those in solid included. 0 when there were none.
double functionsPerProbe(const ShardCounts& counts);

// The attribute schema_version of its files.
inline constexpr uint64_t kShardVersion = 2;

// Functions a chunk of every array in the file: the unit in which shards are written and read.
inline constexpr uint64_t kChunkFunctions = 32;

// Writes the shard atomically: deflate and Fletcher-32 a chunk, SHA-256 over the file, no time stamps: the same shard gives the
// same bytes. For shards that fit in memory; ShardWriter (shard_file.h) takes the others. throws OutputError
void writeShard(const std::string& path, const Shard& shard);

// Reads a shard back, checks every shape against the attributes, the checksums and the SHA-256 against the bytes.
// pattern_hash   the pattern that the caller works with; 0 takes any
// point_count    its points; 0 takes any number
// throws         InputError on a missing, truncated or damaged file, another schema version or another pattern
Shard readShard(const std::string& path, uint64_t pattern_hash, int point_count = 0);

// The same without the N x … arrays: cheap.
Shard readShardHeader(const std::string& path, uint64_t pattern_hash, int point_count = 0);

// Shards of before 27 November have none, and it is 0.
inline constexpr const char* kCountOutside = "count_outside";

// The counts of a shard, listed once, as function_rows.h lists its arrays.
//
// Calls visit(attribute name, field of each of the counts) for every count: writing and reading cannot list different ones.
template <class Visit, class... Counts>
void forEachCount(const Visit& visit, Counts&... counts) {
  visit("count_grid_probes", counts.grid_probes...);
  visit("count_visited_probes", counts.visited_probes...);
  visit("count_functions", counts.functions...);
  visit("count_free_space", counts.free_space...);
  visit("count_in_solid", counts.in_solid...);
  visit("count_duplicates", counts.duplicates...);
  visit("count_empty", counts.empty...);
  visit("count_solid_functions", counts.solid_functions...);
  visit(kCountOutside, counts.outside...);
}

}  // namespace nlg
