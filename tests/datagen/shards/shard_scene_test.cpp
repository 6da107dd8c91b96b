#include "datagen/shards/shard_scene.h"

#include <gtest/gtest.h>

#include "datagen/probes/probe_placement.h"
#include "runtime_eval/numbers/random.h"
#include "scene/procedural/procedural.h"

namespace nlg {
namespace {

constexpr const char* kOptions =
    R"("seed":7,"unit":1.0,"move_m":0.5,"turn_degrees":20.0,"scale":0.15,"drop_share":0.1,"structure_share":0.35,)"
    R"("spacing_min_m":0.9,"spacing_max_m":1.1,"density_growth":0.5,"extent_m":[])";

ShardHeader shardOfAHouse() {
  ShardHeader shard;
  shard.scene_id = "house_3";
  shard.family = "house";
  shard.jitter = 2;
  shard.provenance_json = std::string("{\"options\":{") + kOptions + "},\"inputs\":{}}";
  return shard;
}

TEST(ShardScene, IsTheJitteredSceneOfTheRun) {
  const ShardHeader shard = shardOfAHouse();
  EXPECT_EQ(proceduralRequest(shard), "house:3");
  const Scene scene = rebuildShardScene(shard, "a.h5", "house:3");
  // the derivation, written out: shards that were made before depend on it
  uint64_t id_hash = 0;
  for (const char c : std::string("house_3")) id_hash = mixSeed(id_hash, static_cast<unsigned char>(c));
  const Scene expected = jitterScene(makeProceduralScene("house", 3), JitterOptions{}, mixSeed(7, id_hash, 2) | 1);
  EXPECT_EQ(scene.positions, expected.positions);
  EXPECT_EQ(scene.triangles, expected.triangles);
  EXPECT_NE(scene.positions, makeProceduralScene("house", 3).positions);
}

TEST(ShardScene, TreeIsThatOfTheOptions) {
  const ShardHeader shard = shardOfAHouse();
  const Scene scene = rebuildShardScene(shard, "a.h5", "house:3");
  const ProbeTree tree = rebuildShardTree(shard, "a.h5", scene);
  ProbePlacementOptions placement;
  placement.spacing_min_m = 0.9;
  placement.spacing_max_m = 1.1;
  const ProbeTree expected = placeProbes(scene, placement, shardSeed(7, "house_3", 2));
  ASSERT_EQ(tree.probeCount(), expected.probeCount());
  for (size_t i = 0; i < expected.probeCount(); ++i) EXPECT_EQ(tree.probePosition(i), expected.probePosition(i)) << i;
}

}  // namespace
}  // namespace nlg
