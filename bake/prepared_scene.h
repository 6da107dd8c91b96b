// Prepares a scene for its bake: reads and lights it, places its probes, and finds the air.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "bake/bake_options.h"
#include "datagen/probes/probe_placement.h"
#include "datagen/visibility/ray_scene.h"
#include "light/air_places.h"
#include "nlg/probe_tree.h"
#include "scene/scene_source.h"

namespace nlg {

// A scene, read as the options say, with their sky and suns; what they did stands among its light_notes.
// throws   InputError when the scene cannot be read or has no triangle; UsageError as applyLight does
SceneSource loadLitScene(const std::string& request, const BakeOptions& options);

// A lit scene with a lattice of probes, which stand where the options say, else where the scene's author does, else in the scene's bounds
// and what lies in reach of them (scene_size.h).
struct PlacedScene {
  // throws   UsageError on an extent_m that is none, and on too many probes
  PlacedScene(SceneSource lit, const BakeOptions& options);

  SceneSource source;
  ExtentBox extent;                     // what has probes, relative to the scene's origin
  double spacing_m = 0.0;               // of probes outside boxes with a spacing of their own
  std::optional<ChosenSpacing> chosen;  // where nobody named a spacing
  PlacedBoxes boxes;                    // with a spacing of their own
  ProbeTree full_tree;                  // before cells in solid are left out
  RayScene rays;

 private:
  ProbeTree place(const BakeOptions& options);
};

// Where an earlier bake of the same geometry and settings found air.
struct KnownAir {
  std::string searched_sha256;      // PreparedScene's of that bake; empty: nothing is known
  const ProbeTree* tree = nullptr;  // the grid's
};

// A scene ready for its first probe.
struct PreparedScene : PlacedScene {
  // throws   UsageError on a setting that cannot be used; InputError when the scene cannot be read or has no triangle
  PreparedScene(const std::string& request, const BakeOptions& options);
  // The same of a scene that loadLitScene has read.
  // known     where that bake searched what this one would, no cells without air are searched
  // onPlaced  is called before air is searched for, which takes a minute for a million probes
  PreparedScene(SceneSource lit, const BakeOptions& options, const KnownAir& known = {},
                const std::function<void(const PlacedScene&)>& onPlaced = nullptr);

  // The tree in the world's coordinates, in which engines look up; the scene's are relative to its middle.
  ProbeTree treeInWorld() const;

  std::string searched_sha256;  // of all that light may have a say in when air is searched for: full_tree, faces of sky
  AirPlaces air;                // of full_tree
  ProbeTree tree;
  double air_wall_s = 0.0;  // to find the air
};

}  // namespace nlg
