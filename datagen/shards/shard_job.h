// Prepares one scene under one jitter, for computing a shard and for estimating it.
#pragma once

#include <string>

#include "datagen/dataset/shard.h"
#include "datagen/dataset/shard_file.h"
#include "datagen/functions/function_pipeline.h"
#include "datagen/probes/probe_placement.h"
#include "datagen/probes/shuffled_order.h"
#include "datagen/visibility/hull.h"
#include "datagen/visibility/ray_scene.h"
#include "datagen/weighting/weighting_builder.h"
#include "scene/jitter.h"
#include "scene/scene_source.h"
#include "tool/command/options.h"

namespace nlg {

struct DatagenOptions {
  ProbePlacementOptions probes;
  std::vector<std::string> extent_m;  // becomes probes.extent
  JitterOptions jitter;
  SceneReading reading;
  DiffusionOptions diffusion;
  double in_solid = 0.0;  // share of the probes in solid that have functions, as seen from their eyes
  bool keep_outside = false;
  int max_functions = 1200;
  int max_visited_probes = 4000000;
  int test_points = 2048;
  double duplicate_rms = 0.5;  // half a step of the stored samples: docs/lab/measurements.md
  int duplicate_validity_points = 16;
  int threads = 1;
  uint64_t seed = 1;
};

// Adds every option to the table of the section `datagen`.
void describe(DatagenOptions& options, OptionTable& table);

struct ShardRequest {
  std::string scene;  // "house:3" or a path
  uint64_t jitter = 0;
  bool held_out = false;
};

class ShardJob {
 public:
  // Loads and jitters the scene, places the probes, prepares the rays.
  // table    holds the options, for the shard's provenance
  // What the user should know of the scene's file is said on stderr.
  // throws   UsageError on options that contradict each other, InputError when the scene cannot be read
  ShardJob(const ShardRequest& request, const DatagenOptions& options, const OptionTable& table);

  const Shard& header() const { return header_; }  // everything but counts and arrays
  const Scene& scene() const { return scene_; }
  uint64_t probeCount() const { return tree_.probeCount(); }
  CollectorLimits limits() const;
  // Of the functions of this shard: its points, its rule for duplicates, its chunks. throws OutputError when the spool's disk refuses
  FunctionCollector collector(const CollectorLimits& limits, const std::string& spool_folder) const;

  // The functions of the probes in visiting order, for whoever adds a finisher; serves one run. The job must outlive it.
  FunctionPipeline pipeline() const;

 private:
  ShardJob(const SceneSource& source, const ShardRequest& request, const DatagenOptions& options, const OptionTable& table);
  bool isOutside(const glm::dvec3& position_m, float spacing_m, const GeneratedFunction& function) const;
  void generate(WeightingBuilder& builder, const std::vector<uint64_t>& probes, ProbeBlock* block) const;

  DatagenOptions options_;
  Shard header_;
  uint64_t seed_;
  Scene scene_;
  ProbeTree tree_;
  TestLinks test_links_;
  RayScene rays_;
  Hull hull_;
  mutable ProbeLattice lattice_;  // whose probes and cells threads find when they first ask
};

// What brings the chunks of a shard to its file: compressed in any order, written in theirs. The writer must outlive it.
std::function<FunctionPipeline::Finish(int thread)> appendTo(ShardWriter& writer);

}  // namespace nlg
