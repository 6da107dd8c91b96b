// Derives the scene of a shard, for the run that makes it and for tools that draw it later.
#pragma once

#include <cstdint>
#include <string>

#include "datagen/dataset/shard.h"
#include "nlg/probe_tree.h"
#include "scene/jitter.h"
#include "scene/model/scene.h"

namespace nlg {

// The seed of every random choice of one shard: jitter, probe tree, order of the probes.
// run_seed   option `seed` of the run
uint64_t shardSeed(uint64_t run_seed, const std::string& scene_id, uint64_t jitter);

// The variant of the scene that a shard is about. Jitter 0 is the scene itself.
// shard_seed   as shardSeed gives it for the same jitter
Scene shardScene(const Scene& scene, const JitterOptions& options, uint64_t shard_seed, uint64_t jitter);

// The request by which loadScene makes the shard's scene again: "house:3" for a procedural one, empty for a level, whose file
// the shard does not name.
std::string proceduralRequest(const ShardHeader& shard);

// The jittered scene of a shard, made again from its provenance.
// shard        its header is enough; shard_path is for messages
// request      the scene, as loadScene takes it
// throws       InputError when the provenance lacks an option, or when the scene is not the shard's: another SHA-256 of the file,
//              another id of a procedural scene; whatever loadScene throws
Scene rebuildShardScene(const ShardHeader& shard, const std::string& shard_path, const std::string& request);

// The probe tree of a shard, made again over its jittered scene.
// throws       InputError as above; whatever placeProbes throws
ProbeTree rebuildShardTree(const ShardHeader& shard, const std::string& shard_path, const Scene& scene);

}  // namespace nlg
