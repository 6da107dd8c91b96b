// Writes a function cache (function_cache.h) from shards.
#pragma once

#include <string>
#include <vector>

#include "runtime_eval/evaluator/generator/projection.h"
#include "train/generator/data/function_cache.h"

namespace nlg {

struct CacheReport {
  int64_t functions = 0;   // stored
  int64_t duplicates = 0;  // of functions in earlier shards: left out
  uint64_t bytes = 0;
};

// Reads shard after shard and puts every function, without those that an earlier shard holds (DuplicateFilter), to its shuffled
// place; written atomically. The same shards and basis give the same bytes.
//
// Memory: one shard, about 10 bytes a function, and what DuplicateFilter takes. Disk: as large as the cache, in its folder.
// throws   InputError as readShard does, or when no shard holds a function; OutputError
CacheReport writeFunctionCache(const std::string& path, const std::vector<std::string>& shards, const BasisData& basis,
                               const std::string& basis_sha256);

}  // namespace nlg
