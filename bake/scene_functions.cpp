#include "bake/scene_functions.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "datagen/probes/probe_placement.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

// A window is held in memory whole, at most 10 kB a probe; between windows threads wait for one another.
constexpr uint64_t kBlockProbes = 64, kWindowProbes = 8192;

using Clock = std::chrono::steady_clock;
double secondsBetween(Clock::time_point from, Clock::time_point to) { return std::chrono::duration<double>(to - from).count(); }

ProbeTree placeProbes(const Scene& scene, const BakeOptions& options) {
  ProbePlacementOptions placement;
  placement.spacing_min_m = placement.spacing_max_m = options.spacing_m;
  placement.density_growth = options.density_growth;
  placement.align_lattice = options.align_lattice;
  placement.extent = extentFromNumbers(options.extent_m);
  return placeProbes(scene, placement, options.seed);
}

// So many places at least in the whole scene: a grid of a few probes has few cells, and its light would be fitted to next to
// nothing.
constexpr uint64_t kFewestPlaces = 2048;

AirPlaceOptions airPlaceOptions(const BakeOptions& options, uint64_t cell_count) {
  AirPlaceOptions air;
  const auto for_all = static_cast<int>((kFewestPlaces + cell_count) / std::max<uint64_t>(1, cell_count));
  air.places_per_cell = std::max(options.light_places, for_all);
  air.draws_per_cell = std::max(air.draws_per_cell, 4 * air.places_per_cell);
  air.seed = options.seed;
  return air;
}

}  // namespace

SceneSource loadLitScene(const std::string& request, const BakeOptions& options) {
  SceneSource source = loadScene(request, options.reading);
  if (source.scene.triangles.empty()) throw InputError(request, "triangles", "at least one", "none");
  for (const std::string& done : applyLight(source.scene, options.scene_light)) source.light_notes.push_back(done);
  return source;
}

BakeScene::BakeScene(const std::string& request, const BakeOptions& options)
    : source(loadLitScene(request, options)),
      links(makeLinkTable({})),
      rays(source.scene),
      full_tree(placeProbes(source.scene, options)) {
  const Clock::time_point start = Clock::now();
  air = findAirPlaces(rays, full_tree, airPlaceOptions(options, full_tree.cellCount()),
                      options.threads > 0 ? options.threads : machineThreadCount());
  tree = options.air_only ? treeOfAir(full_tree, air) : full_tree;
  air_wall_s = secondsBetween(start, Clock::now());
}

struct SceneFunctions::ThreadState {
  ThreadState(const BakeScene& scene, const BakeOptions& options) : builder(scene.rays, scene.links, options.diffusion) {}
  WeightingBuilder builder;
  GeneratedFunction function;
  FunctionChecker checker;
  double visibility_s = 0.0, functions_s = 0.0, bare_tent_s = 0.0;
};

SceneFunctions::SceneFunctions(const BakeScene& scene, const BakeOptions& options, int thread_count,
                               const std::string& spool_folder, const LeftOut& left_out)
    : scene_(scene),
      options_(options),
      left_out_(left_out),
      thread_count_(thread_count),
      spool_(spool_folder, kSupportPointCount),
      index_({options.duplicate_rms, static_cast<uint64_t>(options.duplicate_validity_points)}, kSupportPointCount,
             [this](uint64_t id) { return spool_.read(id); }) {
  for (int t = 0; t < thread_count; ++t) threads_.push_back(std::make_unique<ThreadState>(scene, options));
  counts_.grid_probes = scene.tree.probeCount();
}

SceneFunctions::~SceneFunctions() = default;

FunctionTimes SceneFunctions::times() const {
  FunctionTimes times;
  for (const auto& thread : threads_) {
    times.visibility_s += thread->visibility_s;
    times.functions_s += thread->functions_s;
    times.bare_tent_s += thread->bare_tent_s;
  }
  times.duplicates_s = duplicates_s_;
  return times;
}

StoredFunction SceneFunctions::read(uint64_t number, std::vector<uint8_t>* samples) {
  samples->resize(kSupportPointCount + kValidityByteCount);
  const std::lock_guard lock(spool_mutex_);
  const StoredFunction row = spool_.read(number);
  std::memcpy(samples->data(), row.phi, kSupportPointCount);
  std::memcpy(samples->data() + kSupportPointCount, row.validity, kValidityByteCount);
  return {samples->data(), samples->data() + kSupportPointCount};
}

// What a probe comes to: visibility, then the function where there is one. A probe that is not left out goes through both.
ProbeOutcome SceneFunctions::seeAndGenerate(const glm::dvec3& position, float spacing_m, ThreadState& state) const {
  const Clock::time_point start = Clock::now();
  const InSolid in_solid = left_out_.in_solid ? InSolid::by_eye : InSolid::kept;
  ProbeOutcome outcome = state.builder.see(position, spacing_m, {in_solid, left_out_.free_space});
  const Clock::time_point seen = Clock::now();
  state.visibility_s += secondsBetween(start, seen);
  if (outcome != ProbeOutcome::function) return outcome;
  outcome = state.builder.generate(&state.function);
  if (outcome == ProbeOutcome::empty && !left_out_.empty) outcome = ProbeOutcome::function;
  state.functions_s += secondsBetween(seen, Clock::now());
  return outcome;
}

void SceneFunctions::makeBlock(uint64_t first_probe, uint64_t end_probe, ThreadState& state, CheckedBlock* block) const {
  FunctionRows& rows = block->probes.functions;
  rows.point_count = kSupportPointCount;
  for (uint64_t probe = first_probe; probe < end_probe; ++probe) {
    const auto [x, y, z] = scene_.tree.probePosition(probe);
    const glm::dvec3 position(x, y, z);
    const float spacing_m = scene_.tree.probeSpacing(probe);
    ProbeOutcome outcome = seeAndGenerate(position, spacing_m, state);
    if (outcome == ProbeOutcome::function) {
      const Clock::time_point start = Clock::now();
      appendFunction(state.function, scene_.source.scene.origin_m + position, spacing_m, &rows);
      const Clock::time_point appended = Clock::now();
      state.functions_s += secondsBetween(start, appended);
      block->tents.push_back(state.checker.checkBareTent(storedFunction(rows, block->tents.size()), options_.policy.check()));
      state.bare_tent_s += secondsBetween(appended, Clock::now());
    }
    block->probes.outcomes.push_back(outcome);
  }
}

SceneFunctions::NewFunctions SceneFunctions::collect(const std::vector<CheckedBlock>& window) {
  const Clock::time_point start = Clock::now();
  NewFunctions result;
  result.first = counts_.functions;
  for (const CheckedBlock& block : window) {
    uint64_t row = 0;
    for (const ProbeOutcome outcome : block.probes.outcomes) {
      ++counts_.visited_probes;
      counts_.free_space += outcome == ProbeOutcome::free_space;
      counts_.in_solid += outcome == ProbeOutcome::in_solid;
      counts_.empty += outcome == ProbeOutcome::empty;
      if (outcome != ProbeOutcome::function) {
        probe_function_.push_back(outcome == ProbeOutcome::free_space ? kFreeSpace : kNoWeight);
        continue;
      }
      const uint64_t n = row++;
      counts_.solid_functions += (block.probes.functions.flags[n] & kFlagInSolid) != 0;
      const FunctionCheck& tent = block.tents[n];
      const StoredFunction stored = storedFunction(block.probes.functions, n);
      if (takesBareTent(tent, options_.policy)) {
        ++bare_tents_.count;
        bare_tents_.rmse_sum += tent.rmse;
        probe_function_.push_back(kFreeSpace);
        continue;
      }
      const auto match = left_out_.duplicates ? index_.findOrAdd(stored) : std::nullopt;
      probe_function_.push_back(static_cast<uint32_t>(match ? match->id : counts_.functions));
      counts_.duplicates += match.has_value();
      if (match) continue;
      ++counts_.functions;
      spool_.append(stored);
      result.functions.push_back(stored);
      result.tent_passes.push_back(tent.passes(options_.policy.check()));
    }
  }
  duplicates_s_ += secondsBetween(start, Clock::now());
  return result;
}

void SceneFunctions::makeAll(const std::function<void(const NewFunctions&)>& use) {
  const uint64_t probe_count = scene_.tree.probeCount();
  Progress progress("probes", static_cast<int64_t>(probe_count));
  for (uint64_t begin = 0; begin < probe_count; begin += kWindowProbes) {
    const uint64_t end = std::min(begin + kWindowProbes, probe_count);
    std::vector<CheckedBlock> window((end - begin + kBlockProbes - 1) / kBlockProbes);
    parallelFor(window.size(), thread_count_, [&](uint64_t b, int thread) {
      const uint64_t first = begin + b * kBlockProbes;
      makeBlock(first, std::min(first + kBlockProbes, end), *threads_[thread], &window[b]);
    });
    use(collect(window));
    progress.update(static_cast<int64_t>(end));
  }
}

}  // namespace nlg
