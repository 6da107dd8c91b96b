#include "datagen/dataset/shard_rows.h"

#include <algorithm>

#include "tool/error.h"

namespace nlg {

StoredFunction ShardRows::at(uint32_t shard, uint64_t row) {
  const uint64_t chunk = row / kChunkFunctions, first = chunk * kChunkFunctions;
  const Shard& rows = chunks_.get(uint64_t{shard} << 32 | chunk, kChunks, [&] {
    const ShardReader& reader = *open_.get(shard, kOpenShards, [&] { return std::make_unique<ShardReader>(paths_[shard]); });
    NLG_CHECK(row, <, reader.functionCount());
    return reader.read(first, std::min(kChunkFunctions, reader.functionCount() - first));
  });
  return functionAt(rows, row - first);
}

}  // namespace nlg
