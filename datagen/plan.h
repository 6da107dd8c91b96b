// nlg-datagen plan: what generating a shard will take, from a sample of its probes, before anything is written.
#pragma once

#include "datagen/shards/shard_job.h"

namespace nlg {

struct ShardPlan {
  uint64_t grid_probes = 0;
  double visited_probes = 0, functions = 0, bytes = 0;  // of the whole shard
  double scratch_bytes = 0;                             // disk that is taken while it is made, beside the file
  double core_seconds = 0;                              // loading and preparing the scene included
  uint64_t sampled_probes = 0;
  // two standard errors of `functions` or of `visited_probes`, whichever the limits leave open, as a share of it
  double uncertainty = 0;
};

// Generates the first probes of the visiting order, a fair sample, until so many functions have been made, and extrapolates;
// exact when the shard is smaller than the sample. The number of distinct functions among n is taken to grow as n^b (Heaps' law),
// b measured over the second half of the sample.
// throws   as ShardJob
ShardPlan planShard(const ShardRequest& request, const DatagenOptions& options, const OptionTable& table, int sample_functions);

// Prints the plan on stdout: one line of JSON, or text for people.
enum class PlanFormat { text, json };
void printPlan(const ShardRequest& request, const ShardPlan& plan, PlanFormat format);

}  // namespace nlg
