// Computes the distinct weighting functions of all probes of a scene.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "bake/prepared_scene.h"
#include "datagen/functions/function_pipeline.h"

namespace nlg {

// What the functions took and what they looked at. Seconds by the clock, summed over threads.
struct FunctionTimes {
  double visibility_s = 0.0, functions_s = 0.0, bare_tent_s = 0.0, duplicates_s = 0.0;
  double in_solid_s = 0.0;     // of visibility_s: of probes in solid that turned out to have no eye
  uint64_t cavity_probes = 0;  // probes in cavities: those with an eye and those without
};

class BlendTargets;

class SceneFunctions {
 public:
  // spool_folder   where samples lie meanwhile: 9 kB a distinct function, in a file without a name
  SceneFunctions(const PreparedScene& scene, const BakeOptions& options, int thread_count, const std::string& spool_folder);
  ~SceneFunctions();

  // Makes the functions of all probes, and hands them to finishers (FunctionPipeline) in chunks of kBatchCount, the last of fewer.
  // The same functions in the same order for any number of threads. throws OutputError when the spool's disk refuses
  void makeAll(const std::function<FunctionPipeline::Finish(int thread)>& makeFinisher);

  // From now on says of every probe what it should weigh at these points; targets   of this scene; must live until makeAll returns
  void tellTargets(BlendTargets* targets) { targets_ = targets; }

  // By probe: a function's number, kFreeSpace or kNoWeight. Of probes in free space, and of bareTents: kFreeSpace.
  const std::vector<uint32_t>& probeFunction() const { return probe_function_; }
  const ShardCounts& counts() const { return counts_; }
  const TentCounts& bareTents() const { return collector_.bareTents(); }
  FunctionTimes times() const;
  // Makes functions anew, once makeAll has returned: what samples lack (probe, flags, what it sees) is kept nowhere.
  // returns   rows of a shard, in the order of the numbers
  FunctionRows makeAgain(const std::vector<uint32_t>& numbers);
  // The samples of a function that was made; `samples` holds them. Any thread may call it once makeAll has returned.
  StoredFunction read(uint64_t number, std::vector<uint8_t>* samples) const { return collector_.read(number, samples); }

 private:
  struct ThreadState;

  struct PlacedProbe;

  PlacedProbe placed(uint64_t number) const;
  ProbeOutcome see(const PlacedProbe& probe, ThreadState& state);
  bool takesExactTent() const;
  void makeFunction(const PlacedProbe& probe, ThreadState& state, ProbeBlock* block);
  // Of the block's last probe.
  void setTargets(const PlacedProbe& probe, ThreadState& state, const ProbeBlock& block) const;
  void makeProbe(uint64_t number, ThreadState& state, ProbeBlock* block);

  const PreparedScene& scene_;
  BakeOptions options_;
  std::unique_ptr<ProbeLattice> lattice_;  // while makeAll runs
  std::vector<std::unique_ptr<ThreadState>> threads_;
  FunctionCollector collector_;
  std::vector<uint32_t> probe_function_;
  ShardCounts counts_;
  BlendTargets* targets_ = nullptr;
};

}  // namespace nlg
