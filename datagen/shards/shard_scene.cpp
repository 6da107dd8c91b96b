#include "datagen/shards/shard_scene.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datagen/probes/probe_placement.h"
#include "runtime_eval/numbers/random.h"
#include "scene/procedural/procedural.h"
#include "scene/scene_source.h"
#include "tool/error.h"

namespace nlg {
namespace {

uint64_t hashText(const std::string& text) {
  uint64_t hash = 0;
  for (const char c : text) hash = mixSeed(hash, static_cast<unsigned char>(c));
  return hash;
}

// The options of the run that made a shard.
class ShardOptions {
 public:
  ShardOptions(const ShardHeader& shard, const std::string& path) : path_(path) {
    const auto provenance = nlohmann::json::parse(shard.provenance_json, nullptr, false);
    if (!provenance.is_object()) throw InputError(path, "provenance_json", "a JSON object", "other text");
    options_ = provenance.value("options", nlohmann::json());
  }

  // A number of 0 to max, as the option's own range is.
  double real(const std::string& key, double max) const {
    const nlohmann::json value = find(key);
    if (!value.is_number() || !(value.get<double>() >= 0.0 && value.get<double>() <= max))
      fail(key, "a number from 0 to " + std::to_string(max), value);
    return value.get<double>();
  }

  uint64_t integer(const std::string& key) const {
    const nlohmann::json value = find(key);
    if (!value.is_number_unsigned()) fail(key, "an unsigned integer", value);
    return value.get<uint64_t>();
  }

  std::vector<std::string> texts(const std::string& key) const {
    std::vector<std::string> result;
    for (const nlohmann::json& text : find(key)) {
      if (!text.is_string()) fail(key, "a list of texts", find(key));
      result.push_back(text.get<std::string>());
    }
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& expected, const nlohmann::json& got) const {
    throw InputError(path_, "provenance_json, option " + key, expected, got.dump());
  }

  // null when there is none
  nlohmann::json find(const std::string& key) const {
    return options_.is_object() ? options_.value(key, nlohmann::json()) : nlohmann::json();
  }

  std::string path_;
  nlohmann::json options_;
};

}  // namespace

uint64_t shardSeed(uint64_t run_seed, const std::string& scene_id, uint64_t jitter) {
  return mixSeed(run_seed, hashText(scene_id), jitter);
}

Scene shardScene(const Scene& scene, const JitterOptions& options, uint64_t shard_seed, uint64_t jitter) {
  // odd, so that no seed is taken for the scene as it is
  return jitterScene(scene, options, jitter == 0 ? 0 : shard_seed | 1);
}

std::string proceduralRequest(const ShardHeader& shard) {
  const std::vector<std::string>& families = proceduralFamilies();
  if (std::find(families.begin(), families.end(), shard.family) == families.end()) return "";
  const std::string prefix = shard.family + "_";
  return shard.scene_id.rfind(prefix, 0) == 0 ? shard.family + ":" + shard.scene_id.substr(prefix.size()) : "";
}

Scene rebuildShardScene(const ShardHeader& shard, const std::string& shard_path, const std::string& request) {
  const ShardOptions options(shard, shard_path);
  // the jitter that the shard was made with, as its provenance has it; that of a bake's shard has none
  JitterOptions jitter;
  if (shard.jitter != 0) {
    jitter.move_m = options.real("move_m", 1e4);
    jitter.turn_degrees = options.real("turn_degrees", 180.0);
    jitter.scale = options.real("scale", 0.9);
    jitter.drop_share = options.real("drop_share", 1.0);
    jitter.structure_share = options.real("structure_share", 1.0);
  }
  SceneReading reading;
  reading.unit_m = options.real("unit", 1e6);
  const SceneSource source = loadScene(request, reading);
  const std::string wanted = shard.sceneSha256();
  // a file that has changed since has other walls than the functions
  if (source.sha256 != wanted) {
    throw InputError(shard_path, "scene " + shard.scene_id, wanted.empty() ? "a procedural scene" : "a file of SHA-256 " + wanted,
                     request + (source.sha256.empty() ? "" : " of SHA-256 " + source.sha256));
  }
  // procedural scenes have no file: their name and seed say which
  if (wanted.empty() && source.id != shard.scene_id) {
    throw InputError(shard_path, "scene", "'" + shard.scene_id + "'", "'" + source.id + "'");
  }
  // the seed of one scene and variant: the same as when the shard was made
  const uint64_t seed = shardSeed(options.integer("seed"), shard.scene_id, shard.jitter);
  return shardScene(source.scene, jitter, seed, shard.jitter);
}

ProbeTree rebuildShardTree(const ShardHeader& shard, const std::string& shard_path, const Scene& scene) {
  const ShardOptions options(shard, shard_path);
  ProbePlacementOptions placement;
  placement.spacing_min_m = options.real("spacing_min_m", 1e5);
  placement.spacing_max_m = options.real("spacing_max_m", 1e5);
  placement.density_growth = options.real("density_growth", 1e3);
  placement.extent = extentFromNumbers(options.texts("extent_m"));
  return placeProbes(scene, placement, shardSeed(options.integer("seed"), shard.scene_id, shard.jitter));
}

}  // namespace nlg
