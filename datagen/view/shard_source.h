// Loads a shard to draw, with its scene if that is available.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datagen/dataset/shard.h"
#include "datagen/view/function_slice.h"
#include "datagen/view/view.h"
#include "nlg/probe_tree.h"
#include "scene/scene.h"

namespace nlg {

struct ViewedShard {
  Shard shard;
  std::optional<Scene> scene;     // jittered as the shard's; none: a level whose file was not named
  std::optional<ProbeTree> tree;  // none without a scene

  StoredFunction function(uint64_t idx) const;
  glm::dvec3 probePosition(uint64_t idx) const;  // world, metres
  // The scene's triangles around the probe in local coordinates; none when there is no scene.
  std::optional<std::vector<ViewTriangle>> localTriangles(uint64_t idx) const;

  double validShare(uint64_t idx) const;  // of the support points
  double seenShare(uint64_t idx) const;
  // "house_3, jitter 2": what all pictures are headed with.
  std::string title() const;
};

struct LoadOptions {
  std::string scene;       // as ViewOptions::scene
  bool with_tree = false;  // the probe tree takes longer than all the rest on a large level
};

// throws   as view.h says
ViewedShard loadViewedShard(const std::string& shard_path, const LoadOptions& options);

}  // namespace nlg
