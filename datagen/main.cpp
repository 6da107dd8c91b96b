// nlg-datagen: one scene under one jitter → one shard of weighting functions.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "datagen/dataset/shard.h"
#include "datagen/probes/probe_grid.h"
#include "datagen/probes/probe_placement.h"
#include "datagen/scene/jitter.h"
#include "datagen/scene/scene_source.h"
#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/support/random.h"
#include "tool/atomic_file.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"

namespace nlg {
namespace {

struct DatagenOptions {
  ProbePlacementOptions probes;
  std::vector<std::string> extent_m;  // becomes probes.extent
  JitterOptions jitter;
  DiffusionOptions diffusion;
  int max_functions = 1200;
  int max_visited_probes = 4000000;
  int unseen_points = 2048;
  uint64_t seed = 1;
};

void describe(DatagenOptions& o, OptionTable& table) {
  table.add("seed", &o.seed, "seed of every random choice");
  table.add("spacing_min_m", &o.probes.spacing_min_m, "smallest finest probe spacing, metres", 1e-4, 1e5);
  table.add("spacing_max_m", &o.probes.spacing_max_m, "largest finest probe spacing, metres", 1e-4, 1e5);
  table.add("density_growth", &o.probes.density_growth,
            "probe spacing over distance from the nearest triangle; 0: finest everywhere", 0.0, 1e3);
  table.add("extent_m", &o.extent_m,
            "where there are probes: low x, y, z, high x, y, z, metres, world coordinates; none: the scene's bounds");
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

struct Request {
  std::string scene;  // "house:3" or a path
  uint64_t jitter = 0;
  bool held_out = false;
  std::string out;
};

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

void collectFunctions(const Scene& scene, const ProbeTree& tree, const DatagenOptions& options, uint64_t seed, Shard& shard) {
  const LinkTable links = makeLinkTable(unseenPoints(shard.unseen_point_count));
  const RayScene rays(scene);
  WeightingBuilder builder(rays, links, options.diffusion);
  ShardCollector collector(shard);
  GeneratedFunction function;
  shard.counts.grid_probes = tree.probeCount();
  ShuffledOrder order(tree.probeCount(), seed);
  const auto probe_limit = std::min<uint64_t>(tree.probeCount(), options.max_visited_probes);
  Progress progress("probes", static_cast<int64_t>(probe_limit));
  uint64_t index = 0;
  while (shard.counts.functions < static_cast<uint64_t>(options.max_functions) && shard.counts.visited_probes < probe_limit &&
         order.next(&index)) {
    ++shard.counts.visited_probes;
    const auto [x, y, z] = tree.probePosition(index);
    const glm::dvec3 position(x, y, z);
    const float spacing_m = tree.probeSpacing(index);
    switch (builder.build(position, spacing_m, &function)) {
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
        collector.add(function, scene.origin_m + position, spacing_m);
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

void generate(const Request& request, const DatagenOptions& options, const OptionTable& table) {
  if (options.unseen_points % 16 != 0)
    throw UsageError("unseen_points", "a multiple of 16", std::to_string(options.unseen_points));
  ProbePlacementOptions placement = options.probes;
  placement.extent = extentFromNumbers(options.extent_m);
  if (placement.spacing_max_m < placement.spacing_min_m) {
    throw UsageError("spacing_max_m", "at least spacing_min_m", std::to_string(placement.spacing_max_m));
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
  const ProbeTree tree = placeProbes(scene, placement, seed);
  collectFunctions(scene, tree, options, seed, shard);
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

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  CLI::App app{"Generates the weighting functions of one scene under one jitter and writes them as one shard.", "nlg-datagen"};
  nlg::Request request;
  nlg::DatagenOptions options;
  nlg::OptionTable table("datagen");
  nlg::describe(options, table);
  app.add_option("--scene", request.scene,
                 "a .glb or .gltf file, or FAMILY:SEED (house, maze, colonnade, stairs, clutter, outdoor, cave)")
      ->required();
  app.add_option("--jitter", request.jitter, "which variant; 0 is the scene as it is");
  app.add_flag("--held-out", request.held_out, "the scene is for validation: add points that no fit sees");
  app.add_option("--out", request.out, "the shard to write (.h5)")->required();
  return nlg::runTool(argc, argv, app, table, [&] { nlg::generate(request, options, table); });
}
