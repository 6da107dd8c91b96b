#include "datagen/generate.h"

#include <cmath>
#include <cstring>
#include <iostream>
#include <unordered_map>

#include "datagen/dataset/shard.h"
#include "datagen/scene/scene_source.h"
#include "runtime_eval/support/random.h"
#include "tool/error.h"
#include "tool/progress.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

uint64_t hashText(const std::string& text) {
  uint64_t hash = 0;
  for (const char c : text) hash = mixSeed(hash, static_cast<unsigned char>(c));
  return hash;
}

void appendBits(const std::vector<uint8_t>& bits, size_t first, size_t count, std::vector<uint8_t>& bytes) {
  for (size_t i = 0; i < count; i += 8) {
    uint8_t byte = 0;
    for (size_t b = 0; b < 8; ++b) byte |= static_cast<uint8_t>(bits[first + i + b] << b);
    bytes.push_back(byte);
  }
}

// Collects functions into a shard and leaves out those that are there already.
class ShardCollector {
 public:
  explicit ShardCollector(Shard& shard) : shard_(shard) {}

  // Stores the function, or counts it as a duplicate.
  void add(const GeneratedFunction& function, const glm::dvec3& position_m, float spacing_m) {
    const size_t n = shard_.functionCount(), points = shard_.point_count, unseen = shard_.unseen_point_count;
    appendSamples(function, 0, points, shard_.phi);
    appendBits(function.valid, 0, points, shard_.validity);
    if (isDuplicate(n)) {
      shard_.phi.resize(n * points);
      shard_.validity.resize(n * points / 8);
      ++shard_.counts.duplicates;
      return;
    }
    appendBits(function.seen, 0, points, shard_.seen);
    appendSamples(function, points, unseen, shard_.phi_unseen);
    appendBits(function.valid, points, unseen, shard_.validity_unseen);
    appendBits(function.seen, points, unseen, shard_.seen_unseen);
    for (int axis = 0; axis < 3; ++axis) shard_.probe_position_m.push_back(position_m[axis]);
    shard_.spacing_m.push_back(spacing_m);
    shard_.flags.push_back(functionFlags(function));
    ++shard_.counts.functions;
  }

 private:
  static void appendSamples(const GeneratedFunction& function, size_t first, size_t count, std::vector<uint8_t>& bytes) {
    for (size_t i = first; i < first + count; ++i) {
      bytes.push_back(function.valid[i] ? static_cast<uint8_t>(std::lround(255.0f * function.phi[i])) : 0);
    }
  }

  uint8_t functionFlags(const GeneratedFunction& function) const {
    int seen_count = 0;
    for (int i = 0; i < shard_.point_count; ++i) seen_count += function.seen[i];
    uint8_t flags = function.open_shell ? kFlagOpenShell : 0;
    if (100 * seen_count < shard_.point_count) flags |= kFlagFewSeen;
    return flags;
  }

  bool isDuplicate(size_t n) {
    const size_t points = shard_.point_count;
    const uint8_t* phi = &shard_.phi[n * points];
    const uint8_t* validity = &shard_.validity[n * points / 8];
    uint64_t hash = 0;
    for (size_t i = 0; i < points; i += 8) {
      uint64_t word;
      std::memcpy(&word, phi + i, 8);
      hash = mixSeed(hash, word, validity[i / 8]);
    }
    auto [first, last] = by_hash_.equal_range(hash);
    for (; first != last; ++first) {
      const size_t other = first->second;
      if (std::memcmp(phi, &shard_.phi[other * points], points) == 0 &&
          std::memcmp(validity, &shard_.validity[other * points / 8], points / 8) == 0) {
        return true;
      }
    }
    by_hash_.emplace(hash, n);
    return false;
  }

  Shard& shard_;
  std::unordered_multimap<uint64_t, size_t> by_hash_;
};

void collectFunctions(const Scene& scene, const ProbeGrid& grid, const DatagenOptions& options, uint64_t seed, Shard& shard) {
  const LinkTable links = makeLinkTable(unseenPoints(shard.unseen_point_count));
  const RayScene rays(scene);
  WeightingBuilder builder(rays, links, options.diffusion);
  ShardCollector collector(shard);
  GeneratedFunction function;
  shard.counts.grid_probes = grid.probeCount();
  ShuffledOrder order(grid.probeCount(), seed);
  const auto probe_limit = std::min<uint64_t>(grid.probeCount(), options.max_visited_probes);
  Progress progress("probes", static_cast<int64_t>(probe_limit));
  uint64_t index = 0;
  while (shard.counts.functions < static_cast<uint64_t>(options.max_functions) && shard.counts.visited_probes < probe_limit &&
         order.next(&index)) {
    ++shard.counts.visited_probes;
    const glm::dvec3 position = grid.probePosition(index);
    switch (builder.build(glm::vec3(position), grid.spacing_m, &function)) {
      case ProbeOutcome::free_space:
        ++shard.counts.free_space;
        break;
      case ProbeOutcome::in_solid:
        ++shard.counts.in_solid;
        break;
      case ProbeOutcome::empty:
        ++shard.counts.empty;
        break;
      case ProbeOutcome::function:
        collector.add(function, scene.origin_m + position, grid.spacing_m);
        break;
    }
    progress.update(static_cast<int64_t>(shard.counts.visited_probes), std::to_string(shard.counts.functions) + " functions");
  }
}

nlohmann::ordered_json countsJson(const Shard& shard) {
  const ShardCounts& c = shard.counts;
  return {{"scene", shard.scene_id},
          {"jitter", shard.jitter},
          {"grid_probes", c.grid_probes},
          {"visited_probes", c.visited_probes},
          {"functions", c.functions},
          {"free_space", c.free_space},
          {"in_solid", c.in_solid},
          {"duplicates", c.duplicates},
          {"empty", c.empty}};
}

}  // namespace

void describe(DatagenOptions& o, OptionTable& table) {
  table.add("seed", &o.seed, "seed of every random choice");
  table.add("spacing_min_m", &o.grid.spacing_min_m, "smallest probe spacing, metres", 1e-4, 1e5);
  table.add("spacing_max_m", &o.grid.spacing_max_m, "largest probe spacing, metres", 1e-4, 1e5);
  table.add("max_functions", &o.max_functions, "stop a shard after so many functions; probes are visited in random order", 1,
            1 << 22);
  table.add("max_visited_probes", &o.max_visited_probes, "stop a shard after so many probes, most of them empty in sparse scenes",
            1, 2000000000);
  table.add("unseen_points", &o.unseen_points, "points that no fit sees, for held-out shards; a multiple of 16", 0, 65536);
  table.add("move_m", &o.jitter.move_m, "jitter: objects move by up to this, metres", 0.0, 1e4);
  table.add("turn_degrees", &o.jitter.turn_degrees, "jitter: objects turn by up to this", 0.0, 180.0);
  table.add("scale", &o.jitter.scale, "jitter: objects scale by up to this share", 0.0, 0.9);
  table.add("drop_share", &o.jitter.drop_share, "jitter: this share of the objects is left out", 0.0, 1.0);
  table.add("structure_share", &o.jitter.structure_share, "components above this share of the scene's side stay in place", 0.0,
            1.0);
  table.add("diffusion_passes", &o.diffusion.passes, "passes that carry weight round corners", 0, 16);
  table.add("diffusion_sigma", &o.diffusion.sigma, "deviation of the diffusion's Gaussian, shares of the spacing", 1e-3, 10.0);
}

void generate(const GenerationRequest& request, const DatagenOptions& options, const OptionTable& table) {
  if (options.unseen_points % 16 != 0)
    throw UsageError("unseen_points", "a multiple of 16", std::to_string(options.unseen_points));
  if (options.grid.spacing_max_m < options.grid.spacing_min_m) {
    throw UsageError("spacing_max_m", "at least spacing_min_m", std::to_string(options.grid.spacing_max_m));
  }
  SceneSource source = loadScene(request.scene);
  Shard shard;
  shard.scene_id = source.id;
  shard.family = source.family;
  shard.jitter = request.jitter;
  shard.pattern_hash = supportPattern().hash;
  shard.point_count = kSupportPointCount;
  shard.unseen_point_count = request.held_out ? options.unseen_points : 0;
  shard.unseen_pattern_hash = hashPoints(unseenPoints(shard.unseen_point_count));
  nlohmann::ordered_json resolved = table.toJson();
  resolved["scene"] = source.id;
  resolved["jitter"] = request.jitter;
  resolved["held_out"] = request.held_out;
  const std::map<std::string, std::string> inputs =
      source.sha256.empty() ? std::map<std::string, std::string>{} : std::map<std::string, std::string>{{"scene", source.sha256}};
  shard.provenance_json = provenance("nlg-datagen", resolved, inputs).dump();
  const uint64_t seed = mixSeed(options.seed, hashText(source.id), request.jitter);
  const Scene scene = jitterScene(source.scene, options.jitter, request.jitter == 0 ? 0 : seed | 1);
  const ProbeGrid grid = makeProbeGrid(scene, options.grid, seed);
  collectFunctions(scene, grid, options, seed, shard);
  if (scene.triangles.empty())
    std::cerr << "nlg-datagen: " << source.id << ": the scene has no triangle; the shard is empty\n";
  else if (shard.counts.functions == 0)
    std::cerr << "nlg-datagen: " << source.id << ": no probe has a weighting function; the shard is empty\n";
  if (shard.counts.visited_probes < shard.counts.grid_probes &&
      shard.counts.functions < static_cast<uint64_t>(options.max_functions)) {
    std::cerr << "nlg-datagen: " << source.id << ": stopped after " << shard.counts.visited_probes << " of "
              << shard.counts.grid_probes << " probes (max_visited_probes)\n";
  }
  writeShard(request.out, shard);
  nlohmann::ordered_json result = countsJson(shard);
  result["dropped_triangles"] = scene.dropped_triangle_count;
  std::cout << result.dump() << '\n';
}

}  // namespace nlg
