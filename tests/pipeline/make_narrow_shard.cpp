// Writes a shard that bears the support pattern's hash but rows of 16 points: what no tool of ours makes, and none may believe.
// With a second argument its functions are all the same one.
#include "datagen/dataset/shard.h"
#include "runtime_eval/support/point_order.h"

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  constexpr size_t kFunctions = 3, kPoints = 16;
  nlg::Shard shard;
  shard.scene_id = "narrow";
  shard.family = "level";
  shard.pattern_hash = nlg::supportPattern().hash;
  shard.test_pattern_hash = nlg::hashPoints({});
  shard.point_count = kPoints;
  shard.counts.grid_probes = shard.counts.visited_probes = shard.counts.functions = kFunctions;
  shard.provenance_json = "{}";
  for (size_t i = 0; i < kFunctions * kPoints; ++i) shard.phi.push_back(static_cast<uint8_t>(argc == 3 ? 9 : i));
  shard.validity.assign(kFunctions * kPoints / 8, 0xff);
  shard.seen = shard.validity;
  shard.blend_sum.assign(shard.phi.size(), 255);
  shard.probe_position_m.assign(kFunctions * 3, 0.0);
  shard.spacing_m.assign(kFunctions, 1.0f);
  shard.flags.assign(kFunctions, 0);
  nlg::writeShard(argv[1], shard);
  return 0;
}
