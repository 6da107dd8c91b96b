// Computes the functions of many probes on several threads and delivers them in order, for shards and bakes.
//
// Blocks of probes are generated in any order, and collected in visiting order by whichever thread is free. The chunks of distinct
// functions that come together are finished in any order, and what became of them is taken in order again. At any time at most a few
// blocks a thread exist, whatever the number of probes.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "datagen/functions/function_collector.h"

namespace nlg {

struct FunctionPipeline {
  // Fills a block with the outcomes and functions of these probes.
  using Generate = std::function<void(const std::vector<uint64_t>& probes, ProbeBlock* block)>;
  // Does with a chunk what may be done in any order. What it returns is called once, in the order of the chunks.
  using Finish = std::function<std::function<void()>(const FunctionRows& chunk)>;

  // The next probes of the visiting order; none: there are no more. Called by one thread at a time.
  std::function<std::vector<uint64_t>()> nextProbes;
  // Each is called once by every thread, with its number; what they give runs on that thread.
  std::function<Generate(int thread)> makeGenerator;
  std::function<Finish(int thread)> makeFinisher;
  // Called after every block that was collected, by one thread at a time; may be empty.
  std::function<void(const FunctionCollector&)> report;

  // Runs until the collector is full or the probes are used up; everything collected has been finished and taken when it returns.
  // The same calls in the same order for any number of threads, but for what is said to be of any order. Rethrows the first exception
  // of any of the functions.
  void run(int thread_count, FunctionCollector& collector) const;
};

}  // namespace nlg
