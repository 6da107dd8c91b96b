#include "datagen/shards/shard_job.h"

#include <algorithm>
#include <memory>

#include "datagen/shards/shard_scene.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/support/point_order.h"
#include "tool/error.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

// A unit of work: long against what handing it on costs, short against a shard.
constexpr size_t kBlockProbes = 64;

constexpr uint64_t kInSolidStream = 0x736f6c6964;  // of the shard's seed: which probes in solid have functions

ProbeTree placeProbes(const Scene& scene, const DatagenOptions& options, uint64_t seed) {
  ProbePlacementOptions placement = options.probes;
  placement.extent = extentFromNumbers(options.extent_m);
  return placeProbes(scene, placement, seed);
}

// The identity of a shard. What it holds must not depend on the number of threads, so neither does its provenance.
Shard makeHeader(const SceneSource& source, const ShardRequest& request, const DatagenOptions& options,
                 const OptionTable& table) {
  Shard shard;
  shard.scene_id = source.id;
  shard.family = source.family;
  shard.jitter = request.jitter;
  shard.pattern_hash = supportPattern().hash;
  shard.point_count = kSupportPointCount;
  shard.test_point_count = request.held_out ? options.test_points : 0;
  shard.test_pattern_hash = hashPoints(testPoints(shard.test_point_count));
  shard.duplicate_rule = {options.duplicate_rms, static_cast<uint64_t>(options.duplicate_validity_points)};
  nlohmann::ordered_json resolved = table.toJson();
  resolved.erase("threads");
  resolved["scene"] = source.id;
  resolved["jitter"] = request.jitter;
  resolved["held_out"] = request.held_out;
  const std::map<std::string, std::string> inputs =
      source.sha256.empty() ? std::map<std::string, std::string>{} : std::map<std::string, std::string>{{"scene", source.sha256}};
  shard.provenance_json = provenance("nlg-datagen", resolved, inputs).dump();
  return shard;
}

// Every one of so many support points.
constexpr size_t kHullStride = 16;

std::vector<glm::vec3> placesOfPeople(const Scene& scene) {
  std::vector<glm::vec3> places;
  for (const Viewpoint& viewpoint : scene.viewpoints) places.emplace_back(viewpoint.position);
  for (const Lamp& lamp : scene.light.lamps) places.push_back(lamp.position);
  return places;
}

SceneSource loadChecked(const ShardRequest& request, const DatagenOptions& options) {
  if (options.test_points % 16 != 0) throw UsageError("test_points", "a multiple of 16", std::to_string(options.test_points));
  if (options.probes.spacing_max_m < options.probes.spacing_min_m) {
    throw UsageError("spacing_max_m", "at least spacing_min_m", std::to_string(options.probes.spacing_max_m));
  }
  // the setting is wrong whatever the scene: say so before it is loaded
  extentFromNumbers(options.extent_m);
  SceneReading reading = options.reading;
  reading.images = ImageNeed::geometry;  // functions know no light
  SceneSource source = loadScene(request.scene, reading);
  tellNotes("nlg-datagen", source);
  return source;
}

}  // namespace

void describe(DatagenOptions& o, OptionTable& table) {
  table.group("Shard");
  table.add("seed", &o.seed, "seed of every random choice");
  table.group("Scene");
  describe(o.reading, table);
  table.group("Probes");
  table.add("spacing_min_m", &o.probes.spacing_min_m,
            "lower bound of the finest probe spacing, metres; each scene draws its own between the two bounds", 1e-4, 1e5);
  table.add("spacing_max_m", &o.probes.spacing_max_m, "upper bound of the finest probe spacing, metres", 1e-4, 1e5);
  table.add("density_growth", &o.probes.density_growth,
            "ratio of probe spacing to the distance from the nearest triangle: larger values thin probes out faster. 0: finest "
            "spacing everywhere",
            0.0, 1e3);
  table.add("extent_m", &o.extent_m,
            "box that probes fill: x,y,z,X,Y,Z, low and high corner, metres, world coordinates. None: the scene's bounds");
  table.add("in_solid", &o.in_solid,
            "share of the probes in solid for which a function is computed, as seen from a point in air. 0: none", 0.0, 1.0);
  table.add("keep_outside", &o.keep_outside,
            "keep functions whose support lies outside the level's hull, the walls and sky that enclose its cameras, players' "
            "starts and "
            "lamps");
  table.group("Shard");
  table.add("max_functions", &o.max_functions, "maximum number of functions in a shard. Probes are visited in random order", 1,
            1 << 30);
  table.add("max_visited_probes", &o.max_visited_probes,
            "maximum number of probes visited, most of which are empty in sparse scenes", 1, 2000000000);
  table.add("test_points", &o.test_points, "test points of a held-out shard, which no fit sees: a multiple of 16", 0,
            kMaxTestPointCount);
  table.group("Weighting functions");
  table.add("duplicate_rms", &o.duplicate_rms,
            "maximum RMS difference, in steps of 1/255, at which two functions count as one. 0: only identical functions do", 0.0,
            16.0);
  table.add("duplicate_validity_points", &o.duplicate_validity_points,
            "maximum number of support points at which two functions that count as one may differ in validity", 0, 8192);
  table.group("Shard");
  table.add("threads", &o.threads, "number of threads for one shard. Its bytes do not depend on it", 1, 1024);
  table.group("Jitter");
  table.add("move_m", &o.jitter.move_m, "maximum movement of an object, metres", 0.0, 1e4);
  table.add("turn_degrees", &o.jitter.turn_degrees, "maximum rotation of an object, degrees", 0.0, 180.0);
  table.add("scale", &o.jitter.scale, "maximum change of an object's size, as a share", 0.0, 0.9);
  table.add("drop_share", &o.jitter.drop_share, "share of the objects that is left out", 0.0, 1.0);
  table.add("structure_share", &o.jitter.structure_share,
            "size of an object, as a share of the scene's largest side, above which it stays in place", 0.0, 1.0);
  describe(o.diffusion, table);
}

ShardJob::ShardJob(const ShardRequest& request, const DatagenOptions& options, const OptionTable& table)
    : ShardJob(loadChecked(request, options), request, options, table) {}

ShardJob::ShardJob(const SceneSource& source, const ShardRequest& request, const DatagenOptions& options,
                   const OptionTable& table)
    : options_(options),
      header_(makeHeader(source, request, options, table)),
      seed_(shardSeed(options.seed, source.id, request.jitter)),
      scene_(shardScene(source.scene, options.jitter, seed_, request.jitter)),
      tree_(placeProbes(scene_, options, seed_)),
      test_links_(makeTestLinks(testPoints(header_.test_point_count))),
      rays_(scene_),
      hull_(rays_, options.keep_outside ? std::vector<glm::vec3>{} : placesOfPeople(source.scene)),
      lattice_(tree_.frame()) {}

CollectorLimits ShardJob::limits() const {
  return {static_cast<uint64_t>(options_.max_functions),
          std::min<uint64_t>(probeCount(), static_cast<uint64_t>(options_.max_visited_probes))};
}

FunctionCollector ShardJob::collector(const CollectorLimits& limits, const std::string& spool_folder) const {
  return {header_, header_.duplicate_rule, kChunkFunctions, limits, spool_folder};
}

bool ShardJob::isOutside(const glm::dvec3& position_m, float spacing_m, const GeneratedFunction& function) const {
  if (!hull_.isThere()) return false;
  const std::vector<LocalPoint>& points = supportPattern().points;
  for (size_t i = 0; i < points.size(); i += kHullStride) {
    const glm::dvec3 place = position_m + double(spacing_m) * glm::dvec3(points[i][0], points[i][1], points[i][2]);
    if (function.valid[i] != 0 && hull_.holds(glm::vec3(place))) return false;
  }
  return true;
}

void ShardJob::generate(WeightingBuilder& builder, const std::vector<uint64_t>& probes, ProbeBlock* block) const {
  block->functions.point_count = header_.point_count;
  block->functions.test_point_count = header_.test_point_count;
  GeneratedFunction function;
  // probes in the given order: the shard's bytes follow from it
  for (const uint64_t index : probes) {
    const auto [x, y, z] = tree_.probePosition(index);
    const glm::dvec3 position(x, y, z);
    const float spacing_m = tree_.probeSpacing(index);
    // drawn from the probe's own number: threads and limits do not change which probes are tried
    const bool by_eye = Random(mixSeed(seed_, kInSolidStream, index)).chance(options_.in_solid);
    const InSolid in_solid = by_eye ? InSolid::by_eye : InSolid::left_out;
    ProbeOutcome outcome = builder.build(position, spacing_m, &function, in_solid, &lattice_);
    // validity decides which points count for the hull: it is known only now
    if (outcome == ProbeOutcome::function && isOutside(position, spacing_m, function)) outcome = ProbeOutcome::outside;
    block->outcomes.push_back(outcome);
    if (outcome != ProbeOutcome::function) continue;
    FunctionRows& rows = block->functions;
    appendFunction(function, scene_.origin_m + position, spacing_m, &rows);
    builder.sumBlend(function, &rows.blend_sum[rows.blend_sum.size() - kSupportPointCount]);
  }
}

FunctionPipeline ShardJob::pipeline() const {
  FunctionPipeline pipeline;
  pipeline.nextProbes = [order = ShuffledOrder(probeCount(), seed_)]() mutable {
    std::vector<uint64_t> probes;
    uint64_t index = 0;
    while (probes.size() < kBlockProbes && order.next(&index)) probes.push_back(index);
    return probes;
  };
  pipeline.makeGenerator = [this](int) {
    const auto builder = std::make_shared<WeightingBuilder>(rays_, options_.diffusion, &test_links_);
    return [this, builder](const std::vector<uint64_t>& probes, ProbeBlock* block) { generate(*builder, probes, block); };
  };
  return pipeline;
}

std::function<FunctionPipeline::Finish(int thread)> appendTo(ShardWriter& writer) {
  return [&writer](int) {
    return [&writer](const FunctionRows& chunk) {
      return [&writer, encoded = encodeFunctions(chunk, 0, chunk.functionCount())] { writer.append(encoded); };
    };
  };
}

}  // namespace nlg
