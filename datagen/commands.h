// Commands of nlg-datagen: computes the shard of one scene under one jitter, estimates it, describes it, and gives its geometry.
#pragma once

#include <cstring>
#include <string>

#include <nlohmann/json.hpp>

#include "datagen/dataset/shard.h"
#include "datagen/shards/shard_job.h"
#include "scene/scene_source.h"

namespace nlg {

// Generates the shard, writes it to path `out`, and prints its counts on stdout as one line of JSON.
// throws   UsageError, InputError (the scene), OutputError (on a full disk it says what was needed and what is free)
void generate(const ShardRequest& request, const std::string& out, const DatagenOptions& options, const OptionTable& table);

// nlg-datagen plan: what generating a shard will take, from a sample of its probes, before anything is written.
struct ShardPlan {
  uint64_t grid_probes = 0;
  double visited_probes = 0, functions = 0, bytes = 0;  // of the whole shard
  double scratch_bytes = 0;                             // disk that is taken while it is made, beside the file
  double core_seconds = 0;                              // loading and preparing the scene included
  uint64_t sampled_probes = 0;
  // two standard errors of `functions` or of `visited_probes`, whichever the limits leave open, as a share of it
  double uncertainty = 0;
};

// Generates the first probes of the visiting order, a fair sample, until so many functions have been made, and extrapolates;
// exact when the shard is smaller than the sample. The number of distinct functions among n is taken to grow as n^b (Heaps' law),
// b measured over the second half of the sample.
// throws   as ShardJob
ShardPlan planShard(const ShardRequest& request, const DatagenOptions& options, const OptionTable& table, int sample_functions);

// Prints the plan on stdout: one line of JSON, or text for people.
enum class PlanFormat { text, json };
void printPlan(const ShardRequest& request, const ShardPlan& plan, PlanFormat format);

// nlg-datagen info: what a shard is, and whether all of it is sound.
//
// Verifies a shard, in bounded memory, and says what it is: the SHA-256 of the file, checksums and contract of all values, counts
// that add up, and that no two of its functions are duplicates by its own rule.
// throws   DamageError when its own bytes prove that it is damaged, and the system gives every one of them; InputError when it does
//          not hold otherwise: that the system refuses to read, that another tool or version wrote, or that is whole and breaks the
//          contract
nlohmann::ordered_json describeShard(const std::string& path);

// nlg-datagen geometry: the scene of a shard, as pictures of it need it (workflow/shard_pictures.py).
//
// scene_request   as loadScene takes it; empty: the shard's own procedural scene, or none
// returns         JSON: `triangles_m`, 9 numbers each, in the world, and `double_sided`, a boolean each; with the tree also `cells`, [x, y, z
//                 of the lowest corner, side], metres, and `nodes`, of those with probes the same and the level, 0 to 2; null without
//                 a scene
// throws          InputError for a shard that cannot be read, or a scene that is not the shard's
std::string shardGeometry(const std::string& path, const std::string& scene_request, bool with_tree);

// nlg-datagen info FOLDER: what a folder of shards holds, scene by scene, and how hard its functions are.
//
// Reads the shards, or where none are named every shard (.h5) below the folder, in bounded memory.
// returns   `scenes`, a row for each scene of each split, and `all`: probes, functions, what was left out by reason, and of the functions:
//           those that the bare tent is enough for, hard ones, those of probes in solid, the share of dark points; `tent_blend_rmse`, how
//           many functions lie in each bin of the bare tent's blend RMSE
// throws    InputError where there is no shard, or one of them cannot be read
nlohmann::ordered_json dataCard(const std::string& folder, std::vector<std::string> shards = {});

// The same as tables for people.
std::string dataCardText(const nlohmann::ordered_json& card);

// nlg-datagen info SCENE: what a scene holds, without a bake.
//
// Whether `info` takes a request for a shard: a file that ends in .h5, and whatever other file is none that scenes are read from.
bool isShardRequest(const std::string& request);

// Triangles, size, materials, images, what is solid, lights in their units, and what was not read.
// throws   as loadScene does
nlohmann::ordered_json describeScene(const std::string& request, const SceneReading& reading);

// SHA-256 of the scene's geometry as a shard of it names it, by which copies are known; images are read only where it depends on them.
// throws   as loadScene does
std::string sceneDigest(const std::string& request, SceneReading reading);

// What describeScene returns for people, on a dozen lines and one for each thing that was not read.
std::string sceneText(const nlohmann::ordered_json& scene);

// A shard's counts as the tool's results name them.
//
// grid_probes, visited_probes, functions, … as docs/reference/formats.md lists them, without their prefix; then functions_per_probe.
inline nlohmann::ordered_json countsJson(const ShardCounts& counts) {
  nlohmann::ordered_json json;
  forEachCount([&](const char* name, uint64_t count) { json[name + std::strlen("count_")] = count; }, counts);
  json["functions_per_probe"] = functionsPerProbe(counts);
  return json;
}

}  // namespace nlg
