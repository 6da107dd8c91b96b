// Makes the functions of a shard on several threads, and brings them to its file in the order of a single one.
//
// Blocks of probes are generated in any order, collected in visiting order by whichever thread is free, compressed in any order
// and written in order again. At any time at most a few blocks a thread exist, whatever the size of the shard.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "datagen/dataset/shard_writer.h"
#include "datagen/shards/probe_block.h"
#include "datagen/shards/shard_collector.h"

namespace nlg {

struct ShardPipeline {
  // The next probes of the visiting order; none: there are no more. Called by one thread at a time.
  std::function<std::vector<uint64_t>()> nextProbes;
  // Called once by every thread: what it gives fills a block with the outcomes and functions of these probes, on that thread.
  std::function<std::function<void(const std::vector<uint64_t>& probes, ProbeBlock* block)>()> makeGenerator;
  // Called after every block that was collected, by one thread at a time; may be empty.
  std::function<void(const ShardCollector&)> report;

  // Runs until the collector is full or the probes are used up; everything collected has been appended to the writer when it
  // returns. The same bytes for any number of threads. Rethrows the first exception of any of the functions.
  void run(int thread_count, ShardCollector& collector, ShardWriter& writer) const;
};

}  // namespace nlg
