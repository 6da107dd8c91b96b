// The distinct weighting functions of all probes of a scene, made window after window of probes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "bake/left_out.h"
#include "datagen/dataset/duplicate_index.h"
#include "datagen/dataset/row_spool.h"
#include "datagen/dataset/shard.h"
#include "datagen/shards/probe_block.h"
#include "datagen/visibility/link_table.h"
#include "datagen/visibility/ray_scene.h"
#include "light/air_places.h"
#include "runtime_eval/fit/function_check.h"
#include "runtime_eval/light_grid/light_grid.h"
#include "scene/scene_source.h"

namespace nlg {

// A scene, read as the options say, with their sky and suns; what they did stands among its light_notes.
// throws   InputError when the scene cannot be read or has no triangle; UsageError as applyLight does
SceneSource loadLitScene(const std::string& request, const BakeOptions& options);

// A scene ready for its first probe.
struct BakeScene {
  // throws   UsageError on a setting that cannot be used; InputError when the scene cannot be read or has no triangle
  BakeScene(const std::string& request, const BakeOptions& options);

  SceneSource source;
  LinkTable links;
  RayScene rays;
  ProbeTree full_tree;  // before cells in solid were left out
  AirPlaces air;        // of full_tree
  ProbeTree tree;
  double air_wall_s = 0.0;  // to find the air
};

// By the clock, summed over threads.
struct FunctionTimes {
  double visibility_s = 0.0, functions_s = 0.0, bare_tent_s = 0.0, duplicates_s = 0.0;
};

// Functions that the bare tent gives well enough.
struct BareTents {
  uint64_t count = 0;
  double rmse_sum = 0.0;
  double meanRmse() const { return count > 0 ? rmse_sum / static_cast<double>(count) : 0.0; }
};

class SceneFunctions {
 public:
  // spool_folder   where samples lie meanwhile: 9 kB a distinct function, in a file without a name
  SceneFunctions(const BakeScene& scene, const BakeOptions& options, int thread_count, const std::string& spool_folder,
                 const LeftOut& left_out = {});
  ~SceneFunctions();

  // A run of distinct functions: numbers first … first + count - 1, by their samples.
  struct NewFunctions {
    uint64_t first = 0;
    std::vector<StoredFunction> functions;
    std::vector<uint8_t> tent_passes;  // by function: whether the bare tent passes the check
  };
  // Makes the functions of all probes. use is called with the new ones of every window, whose samples last until it returns.
  // The same functions in the same order for any number of threads. throws OutputError when the spool's disk refuses
  void makeAll(const std::function<void(const NewFunctions&)>& use);

  // By probe: a function's number, kFreeSpace or kNoWeight. Of probes in free space, and of bareTents: kFreeSpace.
  const std::vector<uint32_t>& probeFunction() const { return probe_function_; }
  const ShardCounts& counts() const { return counts_; }
  const BareTents& bareTents() const { return bare_tents_; }
  FunctionTimes times() const;
  // The samples of a function that was made; `samples` holds them. Any thread may call it.
  StoredFunction read(uint64_t number, std::vector<uint8_t>* samples);

 private:
  struct ThreadState;
  struct CheckedBlock {
    ProbeBlock probes;
    std::vector<FunctionCheck> tents;  // of the bare tent, by row of probes.functions
  };

  ProbeOutcome seeAndGenerate(const glm::dvec3& position, float spacing_m, ThreadState& state) const;
  void makeBlock(uint64_t first_probe, uint64_t end_probe, ThreadState& state, CheckedBlock* block) const;
  NewFunctions collect(const std::vector<CheckedBlock>& window);

  const BakeScene& scene_;
  BakeOptions options_;
  LeftOut left_out_;
  int thread_count_;
  std::vector<std::unique_ptr<ThreadState>> threads_;
  RowSpool spool_;
  std::mutex spool_mutex_;
  DuplicateIndex index_;
  std::vector<uint32_t> probe_function_;
  BareTents bare_tents_;
  ShardCounts counts_;
  double duplicates_s_ = 0.0;
};

}  // namespace nlg
