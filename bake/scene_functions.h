// A scene made ready for its bake, and the distinct weighting functions of all its probes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "datagen/shards/function_pipeline.h"
#include "datagen/visibility/link_table.h"
#include "datagen/visibility/ray_scene.h"
#include "light/air_places.h"
#include "scene/scene_source.h"

namespace nlg {

// A scene, read as the options say, with their sky and suns; what they did stands among its light_notes.
// throws   InputError when the scene cannot be read or has no triangle; UsageError as applyLight does
SceneSource loadLitScene(const std::string& request, const BakeOptions& options);

// A scene ready for its first probe.
struct BakeScene {
  // throws   UsageError on a setting that cannot be used; InputError when the scene cannot be read or has no triangle
  BakeScene(const std::string& request, const BakeOptions& options);
  // The same of a scene that loadLitScene has read.
  BakeScene(SceneSource lit, const BakeOptions& options);

  SceneSource source;
  LinkTable links;
  RayScene rays;
  ProbeTree full_tree;  // before cells in solid were left out
  AirPlaces air;        // of full_tree
  ProbeTree tree;
  double air_wall_s = 0.0;  // to find the air
};

// What the functions took and what they looked at. Seconds by the clock, summed over threads.
struct FunctionTimes {
  double visibility_s = 0.0, functions_s = 0.0, bare_tent_s = 0.0, duplicates_s = 0.0;
  double in_solid_s = 0.0;  // of visibility_s: of probes in solid that turned out to have no eye
  // Of probes that have a function: triangles in their supports; pairs of 16 links and a triangle that were tested.
  uint64_t triangles = 0, link_tests = 0;
  uint64_t cavity_probes = 0;  // probes in cavities: those with an eye and those without
};

class SceneFunctions {
 public:
  // spool_folder   where samples lie meanwhile: 9 kB a distinct function, in a file without a name
  SceneFunctions(const BakeScene& scene, const BakeOptions& options, int thread_count, const std::string& spool_folder);
  ~SceneFunctions();

  // Makes the functions of all probes, and hands them to finishers (FunctionPipeline) in chunks of kBatchCount, the last of fewer.
  // The same functions in the same order for any number of threads. throws OutputError when the spool's disk refuses
  void makeAll(const std::function<FunctionPipeline::Finish(int thread)>& makeFinisher);

  // By probe: a function's number, kFreeSpace or kNoWeight. Of probes in free space, and of bareTents: kFreeSpace.
  const std::vector<uint32_t>& probeFunction() const { return probe_function_; }
  const ShardCounts& counts() const { return counts_; }
  const TentCounts& bareTents() const { return collector_.bareTents(); }
  FunctionTimes times() const;
  // The samples of a function that was made; `samples` holds them. Any thread may call it once makeAll has returned.
  StoredFunction read(uint64_t number, std::vector<uint8_t>* samples) const { return collector_.read(number, samples); }

 private:
  struct ThreadState;

  ProbeOutcome seeAndGenerate(const glm::dvec3& position, float spacing_m, ThreadState& state) const;
  void makeBlock(const std::vector<uint64_t>& probes, ThreadState& state, ProbeBlock* block) const;

  const BakeScene& scene_;
  BakeOptions options_;
  std::vector<std::unique_ptr<ThreadState>> threads_;
  FunctionCollector collector_;
  std::vector<uint32_t> probe_function_;
  ShardCounts counts_;
};

}  // namespace nlg
