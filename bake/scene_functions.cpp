#include "bake/scene_functions.h"

#include <algorithm>
#include <chrono>

#include "bake/bake_plan.h"
#include "datagen/probes/probe_placement.h"
#include "light/open_sky.h"
#include "runtime_eval/evaluator/projection.h"
#include "runtime_eval/fit/theta_policy.h"
#include "runtime_eval/support/weighting_function.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kBlockProbes = 64;  // long against what handing a block on costs

using Clock = std::chrono::steady_clock;
double secondsBetween(Clock::time_point from, Clock::time_point to) { return std::chrono::duration<double>(to - from).count(); }

ProbeTree placeProbes(const Scene& scene, const BakeOptions& options) {
  const Progress progress("probe tree");
  return placeProbes(scene, placementOf(scene, options), options.seed);
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
  const Progress progress("reading");
  SceneSource source = loadScene(request, options.reading);
  if (source.scene.triangles.empty()) throw InputError(request, "triangles", "at least one", "none");
  const auto isOpen = [](const Scene& scene) { return openShare(scene) > kOpenShare; };
  for (const std::string& done : applyLight(source.scene, options.scene_light, isOpen)) source.light_notes.push_back(done);
  return source;
}

BakeScene::BakeScene(const std::string& request, const BakeOptions& options)
    : BakeScene(loadLitScene(request, options), options) {}

BakeScene::BakeScene(SceneSource lit, const BakeOptions& options)
    : source(std::move(lit)), links(makeLinkTable({})), rays(source.scene), full_tree(placeProbes(source.scene, options)) {
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
  FunctionTimes times;
};

namespace {

FunctionRows supportRows() {
  FunctionRows rows;
  rows.point_count = kSupportPointCount;
  return rows;
}

}  // namespace

SceneFunctions::SceneFunctions(const BakeScene& scene, const BakeOptions& options, int thread_count,
                               const std::string& spool_folder)
    : scene_(scene),
      options_(options),
      threads_(static_cast<size_t>(thread_count)),
      collector_(supportRows(), {options.duplicate_rms, static_cast<uint64_t>(options.duplicate_validity_points)}, kBatchCount,
                 {}, spool_folder) {
  collector_.tellFunctions(&probe_function_);
}

SceneFunctions::~SceneFunctions() = default;

FunctionTimes SceneFunctions::times() const {
  FunctionTimes times;
  for (const auto& thread : threads_) {
    times.visibility_s += thread->times.visibility_s;
    times.functions_s += thread->times.functions_s;
    times.bare_tent_s += thread->times.bare_tent_s;
    times.in_solid_s += thread->times.in_solid_s;
    times.triangles += thread->times.triangles;
    times.cavity_probes += thread->times.cavity_probes;
    times.link_tests += thread->builder.visibility().packetTestCount();
  }
  times.duplicates_s = collector_.seconds();
  return times;
}

// What a probe comes to: visibility, then the function where there is one.
ProbeOutcome SceneFunctions::seeAndGenerate(const glm::dvec3& position, float spacing_m, ThreadState& state) const {
  FunctionTimes& times = state.times;
  const Clock::time_point start = Clock::now();
  const ProbeOutcome seen = state.builder.see(position, spacing_m, InSolid::by_eye);
  const Clock::time_point after = Clock::now();
  times.visibility_s += secondsBetween(start, after);
  times.cavity_probes += state.builder.isInCavity();
  if (seen == ProbeOutcome::in_solid) times.in_solid_s += secondsBetween(start, after);
  if (seen != ProbeOutcome::function) return seen;
  times.triangles += state.builder.visibility().triangles().size();
  const ProbeOutcome outcome = state.builder.generate(&state.function);
  times.functions_s += secondsBetween(after, Clock::now());
  return outcome;
}

void SceneFunctions::makeBlock(const std::vector<uint64_t>& probes, ThreadState& state, ProbeBlock* block) const {
  FunctionRows& rows = block->functions;
  rows.point_count = kSupportPointCount;
  for (const uint64_t probe : probes) {
    const auto [x, y, z] = scene_.tree.probePosition(probe);
    const glm::dvec3 position(x, y, z);
    const float spacing_m = scene_.tree.probeSpacing(probe);
    const ProbeOutcome outcome = seeAndGenerate(position, spacing_m, state);
    block->outcomes.push_back(outcome);
    if (outcome != ProbeOutcome::function) continue;
    const Clock::time_point start = Clock::now();
    appendFunction(state.function, scene_.source.scene.origin_m + position, spacing_m, &rows);
    const Clock::time_point appended = Clock::now();
    state.times.functions_s += secondsBetween(start, appended);
    const FunctionCheck tent =
        state.checker.checkBareTent(storedFunction(rows, rows.functionCount() - 1), options_.policy.check());
    block->bare_tent_rmse.push_back(takesBareTent(tent, options_.policy) ? std::optional(tent.rmse) : std::nullopt);
    state.times.bare_tent_s += secondsBetween(appended, Clock::now());
  }
}

void SceneFunctions::makeAll(const std::function<FunctionPipeline::Finish(int thread)>& makeFinisher) {
  const uint64_t probe_count = scene_.tree.probeCount();
  Progress progress("probes", static_cast<int64_t>(probe_count));
  FunctionPipeline pipeline;
  pipeline.nextProbes = [next = uint64_t{0}, probe_count]() mutable {
    std::vector<uint64_t> probes;
    while (probes.size() < kBlockProbes && next < probe_count) probes.push_back(next++);
    return probes;
  };
  pipeline.makeGenerator = [this](int thread) {
    auto& state = threads_[static_cast<size_t>(thread)];
    state = std::make_unique<ThreadState>(scene_, options_);
    return [this, &state](const std::vector<uint64_t>& probes, ProbeBlock* block) { makeBlock(probes, *state, block); };
  };
  pipeline.makeFinisher = makeFinisher;
  pipeline.report = [&](const FunctionCollector& collector) {
    progress.update(static_cast<int64_t>(collector.counts().visited_probes));
  };
  pipeline.run(static_cast<int>(threads_.size()), collector_);
  counts_ = collector_.counts();
  counts_.grid_probes = probe_count;
}

}  // namespace nlg
