#include "datagen/view/shard_source.h"

#include "datagen/shards/shard_scene.h"
#include "tool/error.h"

namespace nlg {
namespace {

double shareOfBits(const uint8_t* bytes) {
  int count = 0;
  for (int i = 0; i < kValidityByteCount; ++i) count += __builtin_popcount(bytes[i]);
  return static_cast<double>(count) / kSupportPointCount;
}

}  // namespace

StoredFunction ViewedShard::function(uint64_t idx) const {
  NLG_CHECK(idx, <, shard.functionCount());
  return functionAt(shard, idx);
}

glm::dvec3 ViewedShard::probePosition(uint64_t idx) const {
  return {shard.probe_position_m[3 * idx], shard.probe_position_m[3 * idx + 1], shard.probe_position_m[3 * idx + 2]};
}

std::optional<std::vector<ViewTriangle>> ViewedShard::localTriangles(uint64_t idx) const {
  if (!scene) return std::nullopt;
  return trianglesNear(*scene, probePosition(idx), shard.spacing_m[idx], 1.0 + kSliceReach);
}

double ViewedShard::validShare(uint64_t idx) const { return shareOfBits(function(idx).validity); }
double ViewedShard::seenShare(uint64_t idx) const { return shareOfBits(function(idx).seen); }

std::string ViewedShard::title() const { return shard.scene_id + ", jitter " + std::to_string(shard.jitter); }

ViewedShard loadViewedShard(const std::string& shard_path, const LoadOptions& options) {
  ViewedShard viewed;
  viewed.shard = readShard(shard_path, supportPattern().hash, kSupportPointCount);
  if (viewed.shard.functionCount() == 0) throw InputError(shard_path, "dataset phi", "at least one function", "none");
  const std::string request = options.scene.empty() ? proceduralRequest(viewed.shard) : options.scene;
  if (!request.empty()) viewed.scene = rebuildShardScene(viewed.shard, shard_path, request);
  if (viewed.scene && options.with_tree) viewed.tree = rebuildShardTree(viewed.shard, shard_path, *viewed.scene);
  return viewed;
}

}  // namespace nlg
