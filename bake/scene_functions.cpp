#include "bake/scene_functions.h"

#include <algorithm>
#include <chrono>

#include "bake/blend_error.h"
#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/support/weighting_function.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kBlockProbes = 64;  // long against what handing a block on costs

using Clock = std::chrono::steady_clock;
double secondsBetween(Clock::time_point from, Clock::time_point to) { return std::chrono::duration<double>(to - from).count(); }

FunctionRows supportRows() {
  FunctionRows rows;
  rows.point_count = kSupportPointCount;
  return rows;
}

}  // namespace

struct SceneFunctions::ThreadState {
  ThreadState(const PreparedScene& scene, const BakeOptions& options) : builder(scene.rays, scene.links, options.diffusion) {}
  WeightingBuilder builder;
  GeneratedFunction function;
  FunctionChecker checker;
  FunctionTimes times;
};

SceneFunctions::SceneFunctions(const PreparedScene& scene, const BakeOptions& options, int thread_count,
                               const std::string& spool_folder)
    : scene_(scene),
      options_(options),
      eyes_(scene.tree.frame()),
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

struct SceneFunctions::PlacedProbe {
  uint64_t number;
  glm::dvec3 position;
  float spacing_m;
  Clock::time_point start;              // when it was begun
  std::optional<ProbeOutcome> settled;  // by that
};

// What a probe comes to that was begun: visibility, then the function where there is one.
ProbeOutcome SceneFunctions::seeAndGenerate(const PlacedProbe& probe, ThreadState& state) const {
  FunctionTimes& times = state.times;
  const ProbeOutcome seen = probe.settled ? *probe.settled : state.builder.look();
  const Clock::time_point after = Clock::now();
  times.visibility_s += secondsBetween(probe.start, after);
  if (seen == ProbeOutcome::in_solid) times.in_solid_s += secondsBetween(probe.start, after);
  if (seen != ProbeOutcome::function) return seen;
  times.triangles += state.builder.visibility().triangles().size();
  const ProbeOutcome outcome = state.builder.generate(&state.function);
  times.functions_s += secondsBetween(after, Clock::now());
  return outcome;
}

void SceneFunctions::makeFunction(const PlacedProbe& probe, ThreadState& state, ProbeBlock* block) const {
  FunctionRows& rows = block->functions;
  const ProbeOutcome outcome = seeAndGenerate(probe, state);
  block->outcomes.push_back(outcome);
  if (outcome != ProbeOutcome::function) return;
  const Clock::time_point start = Clock::now();
  appendFunction(state.function, scene_.source.scene.origin_m + probe.position, probe.spacing_m, &rows);
  const Clock::time_point appended = Clock::now();
  state.times.functions_s += secondsBetween(start, appended);
  const auto sumBlend = [&] {
    state.builder.sumBlend(state.function, &rows.blend_sum[rows.blend_sum.size() - kSupportPointCount]);
  };
  const auto checkBareTent = [&] {
    const StoredFunction function = storedFunction(rows, rows.functionCount() - 1);
    return state.checker.checkBareTent(function, options_.policy.check());
  };
  // sums are dear: nobody asks for those of a function that is a bare tent without them, if they have no say in it
  FunctionCheck tent = checkBareTent();
  bool is_tent = takesBareTent(tent, options_.policy);
  if (!is_tent || state.checker.isPartlyLit(storedFunction(rows, rows.functionCount() - 1))) sumBlend();
  if (is_tent) tent = checkBareTent();
  is_tent = is_tent && takesBareTent(tent, options_.policy);
  block->bare_tent_rmse.push_back(is_tent ? std::optional(tent.rmse) : std::nullopt);
  state.times.bare_tent_s += secondsBetween(appended, Clock::now());
}

void SceneFunctions::setTargets(const PlacedProbe& probe, const ThreadState& state, const ProbeBlock& block) const {
  const ProbeOutcome outcome = block.outcomes.back();
  if (outcome == ProbeOutcome::free_space) return targets_->setTargets(probe.number, {}, nullptr);
  if (outcome != ProbeOutcome::function) return;
  targets_->setTargets(probe.number, state.builder.visibility().eye(),
                       [&] { return storedFunction(block.functions, block.functions.functionCount() - 1); });
}

void SceneFunctions::makeProbe(uint64_t number, ThreadState& state, ProbeBlock* block) {
  const auto [x, y, z] = scene_.tree.probePosition(number);
  PlacedProbe probe{number, {x, y, z}, scene_.tree.probeSpacing(number), Clock::now(), {}};
  probe.settled = state.builder.begin(probe.position, probe.spacing_m, InSolid::by_eye, &eyes_);
  state.times.cavity_probes += state.builder.isInCavity();
  makeFunction(probe, state, block);
  if (targets_ != nullptr) setTargets(probe, state, *block);
}

void SceneFunctions::makeAll(const std::function<FunctionPipeline::Finish(int thread)>& makeFinisher) {
  const uint64_t probe_count = scene_.tree.probeCount();
  Progress progress("probes", static_cast<int64_t>(probe_count));
  FunctionPipeline pipeline;
  // blocks of probes in their order
  pipeline.nextProbes = [next = uint64_t{0}, probe_count]() mutable {
    std::vector<uint64_t> probes;
    while (probes.size() < kBlockProbes && next < probe_count) probes.push_back(next++);
    return probes;
  };
  pipeline.makeGenerator = [this](int thread) {
    auto& state = threads_[static_cast<size_t>(thread)];
    state = std::make_unique<ThreadState>(scene_, options_);
    return [this, &state](const std::vector<uint64_t>& probes, ProbeBlock* block) {
      block->functions.point_count = kSupportPointCount;
      for (const uint64_t probe : probes) makeProbe(probe, *state, block);
    };
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
