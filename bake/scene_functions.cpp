#include "bake/scene_functions.h"

#include <algorithm>
#include <chrono>
#include <optional>

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
  ThreadState(const PreparedScene& scene, const BakeOptions& options)
      : builder(scene.rays, options.diffusion, nullptr, options.points()) {}
  WeightingBuilder builder;
  GeneratedFunction function;
  FunctionChecker checker;
  FunctionTimes times;
};

SceneFunctions::SceneFunctions(const PreparedScene& scene, const BakeOptions& options, int thread_count,
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
    times.cavity_probes += thread->times.cavity_probes;
  }
  times.duplicates_s = collector_.seconds();
  return times;
}

struct SceneFunctions::PlacedProbe {
  uint64_t number;
  glm::dvec3 position;
  float spacing_m;
};

SceneFunctions::PlacedProbe SceneFunctions::placed(uint64_t number) const {
  const auto [x, y, z] = scene_.tree.probePosition(number);
  return {number, {x, y, z}, scene_.tree.probeSpacing(number)};
}

ProbeOutcome SceneFunctions::see(const PlacedProbe& probe, ThreadState& state) {
  FunctionTimes& times = state.times;
  const Clock::time_point start = Clock::now();
  const ProbeOutcome seen = state.builder.see(probe.position, probe.spacing_m, InSolid::by_eye, lattice_.get());
  const Clock::time_point after = Clock::now();
  times.visibility_s += secondsBetween(start, after);
  times.cavity_probes += state.builder.sight().vote.in_cavity;
  if (seen == ProbeOutcome::in_solid) times.in_solid_s += secondsBetween(start, after);
  return seen;
}

void SceneFunctions::makeFunction(const PlacedProbe& probe, ThreadState& state, ProbeBlock* block) {
  FunctionRows& rows = block->functions;
  const ProbeOutcome seen = see(probe, state);
  if (seen == ProbeOutcome::function && takesExactTent() && state.builder.isBareTent()) {
    // nobody looks at the samples where the bare tent stands for them
    block->outcomes.push_back(seen);
    appendZeros(&rows);
    rows.flags.back() = state.builder.sight().vote.solid() ? kFlagInSolid : 0;
    block->bare_tent_rmse.push_back(0.0);
    return;
  }
  const Clock::time_point start = Clock::now();
  const ProbeOutcome outcome = seen == ProbeOutcome::function ? state.builder.generate(&state.function) : seen;
  block->outcomes.push_back(outcome);
  if (outcome != ProbeOutcome::function) return;
  appendFunction(state.function, scene_.source.scene.origin_m + probe.position, probe.spacing_m, &rows);
  state.builder.sumBlend(state.function, &rows.blend_sum[rows.blend_sum.size() - kSupportPointCount]);
  const Clock::time_point appended = Clock::now();
  state.times.functions_s += secondsBetween(start, appended);
  const FunctionCheck tent = state.checker.checkBareTent(storedFunction(rows, rows.functionCount() - 1), options_.policy.check());
  block->bare_tent_rmse.push_back(takesBareTent(tent, options_.policy) ? std::optional(tent.rmse) : std::nullopt);
  state.times.bare_tent_s += secondsBetween(appended, Clock::now());
}

// Whether a function that is the bare tent, without error, takes no theta.
bool SceneFunctions::takesExactTent() const {
  FunctionCheck exact;
  exact.valid_count = 1;
  return takesBareTent(exact, options_.policy);
}

void SceneFunctions::setTargets(const PlacedProbe& probe, ThreadState& state, const ProbeBlock& block) const {
  const ProbeOutcome outcome = block.outcomes.back();
  if (outcome == ProbeOutcome::free_space) return targets_->setTargets(probe.number, {}, nullptr);
  if (outcome != ProbeOutcome::function) return;
  FunctionRows anew = supportRows();
  targets_->setTargets(probe.number, *state.builder.sight().eye, [&] {
    if (!block.bare_tent_rmse.back()) return storedFunction(block.functions, block.functions.functionCount() - 1);
    // the samples of what is all but the bare tent may never have been made
    state.builder.generate(&state.function);
    appendFunction(state.function, probe.position, probe.spacing_m, &anew);
    return storedFunction(anew, 0);
  });
}

void SceneFunctions::makeProbe(uint64_t number, ThreadState& state, ProbeBlock* block) {
  const PlacedProbe probe = placed(number);
  makeFunction(probe, state, block);
  if (targets_ != nullptr) setTargets(probe, state, *block);
}

void SceneFunctions::makeAll(const std::function<FunctionPipeline::Finish(int thread)>& makeFinisher) {
  const uint64_t probe_count = scene_.tree.probeCount();
  Progress progress("probes", static_cast<int64_t>(probe_count));
  lattice_ = std::make_unique<ProbeLattice>(scene_.tree.frame());
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
  lattice_.reset();
  counts_ = collector_.counts();
  counts_.grid_probes = probe_count;
}

FunctionRows SceneFunctions::makeAgain(const std::vector<uint32_t>& numbers) {
  // of the probes with a function the first one made it, the others have duplicates of it
  std::vector<uint64_t> maker(counts_.functions);
  for (uint64_t probe = probe_function_.size(); probe-- > 0;) {
    if (probe_function_[probe] < maker.size()) maker[probe_function_[probe]] = probe;
  }
  lattice_ = std::make_unique<ProbeLattice>(scene_.tree.frame());
  std::vector<ProbeBlock> made(numbers.size());
  parallelFor(numbers.size(), static_cast<int>(threads_.size()), [&](uint64_t i, int thread) {
    made[i].functions.point_count = kSupportPointCount;
    makeFunction(placed(maker[numbers[i]]), *threads_[static_cast<size_t>(thread)], &made[i]);
  });
  lattice_.reset();
  FunctionRows rows = supportRows();
  for (const ProbeBlock& block : made) appendRows(block.functions, 0, 1, &rows);
  return rows;
}

}  // namespace nlg
