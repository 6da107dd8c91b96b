#include "bake/scene_functions.h"

#include <algorithm>
#include <chrono>

#include "bake/blend_error.h"
#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/support/weighting_function.h"
#include "tool/error.h"
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
  std::vector<uint8_t> samples;
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
    times.seen_probes += thread->times.seen_probes;
    times.kept_probes += thread->times.kept_probes;
    times.kept_functions += thread->times.kept_functions;
    times.kept_s += thread->times.kept_s;
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
  times.seen_probes += !probe.settled;
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

bool SceneFunctions::takeKnown(const PlacedProbe& probe, const KeptKey& key, ThreadState& state, ProbeBlock* block) {
  const KeptProbe* known = known_->findProbe(state.builder, key);
  if (known == nullptr) return false;
  // what is known serves the next bake, too
  kept_[probe.number] = *known;
  ++state.times.kept_probes;
  block->outcomes.push_back(known->outcome);
  state.times.kept_functions += known->outcome == ProbeOutcome::function || known->outcome == ProbeOutcome::empty;
  if (known->outcome != ProbeOutcome::function) return true;
  block->bare_tent_rmse.push_back(known->bare_tent_rmse);
  // nobody looks at the samples where the bare tent stands for them, and in a bake nobody at what the probe sees
  state.samples.assign(kKeptSampleBytes, 0);
  if (known->function && !unpackSamples(known->function->packed, &state.samples))
    throw InputError("--keep", "samples of a function", "compressed samples", "other bytes");
  // rows as a function that was generated would have them
  FunctionRows& rows = block->functions;
  const auto validity = state.samples.begin() + kSupportPointCount, sums = validity + kValidityByteCount;
  rows.phi.insert(rows.phi.end(), state.samples.begin(), validity);
  rows.validity.insert(rows.validity.end(), validity, sums);
  rows.blend_sum.insert(rows.blend_sum.end(), sums, state.samples.end());
  rows.seen.resize(rows.seen.size() + kValidityByteCount, 0);
  const glm::dvec3 position_m = scene_.source.scene.origin_m + probe.position;
  rows.probe_position_m.insert(rows.probe_position_m.end(), {position_m.x, position_m.y, position_m.z});
  rows.spacing_m.push_back(probe.spacing_m);
  rows.flags.push_back(known->flags);
  return true;
}

// Of the block's last probe.
void SceneFunctions::note(const PlacedProbe& probe, const KeptKey& key, const ThreadState& state, const ProbeBlock& block) {
  KeptProbe& kept = kept_[probe.number].emplace();
  kept.key = key;
  kept.asked = state.builder.visibility().asked();
  kept.outcome = block.outcomes.back();
  if (kept.outcome != ProbeOutcome::function) return;
  kept.eye = state.builder.visibility().eye();
  kept.flags = block.functions.flags.back();
  kept.bare_tent_rmse = block.bare_tent_rmse.back();
  if (kept.bare_tent_rmse) return;
  const StoredFunction samples = storedFunction(block.functions, block.functions.functionCount() - 1);
  const KeptKey samples_key = keyOf(samples);
  kept.function = known_->findFunction(samples_key);
  if (!kept.function) kept.function = std::make_shared<KeptFunction>(KeptFunction{samples_key, packSamples(samples), {}});
}

void SceneFunctions::setTargets(const PlacedProbe& probe, bool is_known, ThreadState& state, const ProbeBlock& block) {
  const ProbeOutcome outcome = block.outcomes.back();
  if (outcome == ProbeOutcome::free_space) return targets_->setTargets(probe.number, {}, nullptr);
  if (outcome != ProbeOutcome::function) return;
  FunctionRows anew = supportRows();
  targets_->setTargets(probe.number, is_known ? kept_[probe.number]->eye : state.builder.visibility().eye(), [&] {
    if (!is_known || !block.bare_tent_rmse.back()) return storedFunction(block.functions, block.functions.functionCount() - 1);
    // nobody keeps the samples of what is all but the bare tent
    state.builder.look();
    state.builder.generate(&state.function);
    appendFunction(state.function, probe.position, probe.spacing_m, &anew);
    return storedFunction(anew, 0);
  });
}

void SceneFunctions::makeProbe(uint64_t number, ThreadState& state, ProbeBlock* block) {
  const auto [x, y, z] = scene_.tree.probePosition(number);
  PlacedProbe probe{number, {x, y, z}, scene_.tree.probeSpacing(number), Clock::now(), {}};
  probe.settled = state.builder.begin(probe.position, probe.spacing_m, InSolid::by_eye, &eyes_);
  state.times.cavity_probes += state.builder.isInCavity();
  const bool is_noted = known_ != nullptr && !probe.settled;
  const KeptKey key = is_noted ? keyOf(state.builder) : KeptKey{};
  const bool is_known = is_noted && takeKnown(probe, key, state, block);
  if (is_known) {
    state.times.kept_s += secondsBetween(probe.start, Clock::now());
  } else {
    makeFunction(probe, state, block);
    if (is_noted) note(probe, key, state, *block);
  }
  if (targets_ != nullptr) setTargets(probe, is_known, state, *block);
}

void SceneFunctions::keep(const KeptIndex& known) {
  known_ = &known;
  kept_.resize(scene_.tree.probeCount());
}

KeptProbes SceneFunctions::takeKept() {
  KeptProbes probes;
  for (std::optional<KeptProbe>& kept : kept_) {
    if (kept) probes.push_back(std::move(*kept));
  }
  kept_.clear();
  mergeAlike(&probes);
  return probes;
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
