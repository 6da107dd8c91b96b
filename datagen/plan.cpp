#include "datagen/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "datagen/functions/nameless_file.h"
#include "tool/printable.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr uint64_t kSampleProbes = 20000;                // at most: most probes of a sparse scene cost next to nothing
constexpr double kFileBytes = 7.4e3;                     // attributes and HDF5's own bookkeeping
constexpr double kIndexBytes = 200.0 / kChunkFunctions;  // HDF5's bookkeeping a chunk, nine arrays

struct Sample {
  ShardCounts counts;
  uint64_t half_made = 0, half_kept = 0;  // functions made and kept in the first half of the sample
  double bytes = 0, seconds = 0;
  bool whole = false;  // the limits or the probes ended before the sample did

  uint64_t made() const { return counts.functions + counts.duplicates; }
};

// functions   how many are made, duplicates included
Sample takeSample(const ShardJob& job, uint64_t functions) {
  Sample sample;
  FunctionCollector collector = job.collector(job.limits(), temporaryFolder());
  const FunctionPipeline pipeline = job.pipeline();
  const auto generate = pipeline.makeGenerator(0);
  const double start = threadSeconds();
  // encoded as the writer does: these bytes are what the file would take
  const auto encode = [&](const FunctionRows& chunk) {
    if (chunk.functionCount() == 0) return;
    for (const auto& array : encodeFunctions(chunk, 0, chunk.functionCount()).arrays)
      sample.bytes += static_cast<double>(array.size());
  };
  // in the shard's own order of probes: a prefix of it is a fair sample
  while (sample.made() < functions && sample.counts.visited_probes < kSampleProbes) {
    const std::vector<uint64_t> probes = pipeline.nextProbes();
    sample.whole = probes.empty() || collector.full();
    if (sample.whole) break;
    ProbeBlock block;
    generate(probes, &block);
    for (const FunctionRows& chunk : collector.add(block)) encode(chunk);
    sample.counts = collector.counts();
    // functions known at half of the sample tell how fast duplicates grow
    if (sample.made() <= functions / 2) {
      sample.half_made = sample.made();
      sample.half_kept = sample.counts.functions;
    }
  }
  sample.seconds = threadSeconds() - start;
  encode(collector.takeRest());
  return sample;
}

// The exponent of Heaps' law over the second half of the sample.
double growthExponent(const Sample& sample) {
  if (sample.half_kept == 0 || sample.half_made == sample.made()) return 1.0;
  const double kept = static_cast<double>(sample.counts.functions) / static_cast<double>(sample.half_kept);
  const double made = static_cast<double>(sample.made()) / static_cast<double>(sample.half_made);
  return std::clamp(std::log(kept) / std::log(made), 0.2, 1.0);
}

// Takes the sample to the shard's limits: visited probes, functions and the error of what remains open.
void extrapolate(const Sample& sample, const CollectorLimits& limits, ShardPlan* plan) {
  const auto visited = static_cast<double>(sample.counts.visited_probes), made = static_cast<double>(sample.made()),
             kept = static_cast<double>(sample.counts.functions);
  plan->visited_probes = visited;
  plan->functions = kept;
  // the sample was the whole shard
  if (sample.whole) return;
  plan->visited_probes = static_cast<double>(limits.visited_probes);
  if (made == 0.0) {
    plan->uncertainty = 1.0;  // nothing is known but that functions are rare
    return;
  }
  // functions grow as a power of visited probes, since duplicates become more frequent
  const double exponent = growthExponent(sample), most = static_cast<double>(limits.functions);
  plan->functions = kept * std::pow(plan->visited_probes / visited, exponent);
  const double share = made / visited, distinct = kept / made;
  double exponent_error = std::sqrt(2.0 * (1.0 - distinct) / (distinct * made)) / std::log(2.0);
  double growth = 1.0;
  // the limit on functions ends the shard first
  if (plan->functions > most) {
    plan->functions = most;
    plan->visited_probes = std::min(plan->visited_probes, visited * std::pow(most / kept, 1.0 / exponent));
    growth = 1.0 / exponent;
  }
  exponent_error *= growth * std::abs(std::log(plan->visited_probes / visited));
  // two standard deviations: of the share of probes that have a function, and of the exponent
  plan->uncertainty = 2.0 * std::hypot(growth * std::sqrt((1.0 - share) / made), exponent_error);
}

}  // namespace

ShardPlan planShard(const ShardRequest& request, const DatagenOptions& options, const OptionTable& table, int sample_functions) {
  const double start = threadSeconds();
  const ShardJob job(request, options, table);
  const double prepared = threadSeconds();
  const Sample sample = takeSample(job, static_cast<uint64_t>(sample_functions));
  ShardPlan plan;
  plan.grid_probes = job.probeCount();
  plan.sampled_probes = sample.counts.visited_probes;
  extrapolate(sample, job.limits(), &plan);
  const double sampled = std::max<double>(1.0, static_cast<double>(sample.counts.visited_probes));
  const double kept = std::max<double>(1.0, static_cast<double>(sample.counts.functions));
  plan.core_seconds = prepared - start + sample.seconds * plan.visited_probes / sampled;
  plan.bytes = kFileBytes + (sample.bytes / kept + kIndexBytes) * plan.functions;
  plan.scratch_bytes = static_cast<double>(kSupportPointCount) * 9 / 8 * plan.functions;
  return plan;
}

void printPlan(const ShardRequest& request, const ShardPlan& plan, PlanFormat format) {
  // one line for programs, which add up shards
  if (format == PlanFormat::json) {
    const nlohmann::ordered_json line = {{"scene", request.scene},
                                         {"jitter", request.jitter},
                                         {"grid_probes", plan.grid_probes},
                                         {"visited_probes", std::llround(plan.visited_probes)},
                                         {"functions", std::llround(plan.functions)},
                                         {"bytes", std::llround(plan.bytes)},
                                         {"scratch_bytes", std::llround(plan.scratch_bytes)},
                                         {"core_seconds", plan.core_seconds},
                                         {"sampled_probes", plan.sampled_probes},
                                         {"uncertainty", plan.uncertainty}};
    std::cout << line.dump() << '\n';
    return;
  }
  std::cout << fmt::format(
      "{}, jitter {}: plan from {} of {} probes, +- {:.0f} %\n"
      "  visited probes  {:.0f}\n  functions       {:.0f}\n  file            {:.2f} MB\n  scratch         {:.2f} MB\n"
      "  one core        {:.1f} s\n",
      printable(request.scene), request.jitter, plan.sampled_probes, plan.grid_probes, 100.0 * plan.uncertainty,
      plan.visited_probes, plan.functions, plan.bytes / 1e6, plan.scratch_bytes / 1e6, plan.core_seconds);
}

}  // namespace nlg
