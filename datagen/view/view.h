// Draws a shard (`nlg-datagen view`), so that leaks, holes and errors can be seen.
//
// All of them are PNG files, written whole or not at all; the same shard, scene and options give the same bytes.
// They draw the geometry when the scene is at hand: a procedural scene is made again from what the shard says; a level's file has
// to be named and must be the one that the shard was made from (SHA-256 of its geometry). Without it the pictures say that it is
// missing.
//
// What all functions below throw:
//   InputError    a shard that is missing, damaged, of another support pattern, or empty; a scene that is not the shard's
//   UsageError    an option out of its range, a function that the shard does not have
//   OutputError   a picture that cannot be written
#pragma once

#include <cstdint>
#include <string>

namespace nlg {

struct ViewOptions {
  std::string scene;  // as loadScene takes it; empty: the shard's own procedural scene, or none
  uint64_t seed = 1;  // atlas: which functions
  // top view: where the level is cut: metres ("2.5", world) or a share of its height ("40%"); empty: where it opens most rooms,
  // in the middle half of the height
  std::string height;
  int slice_px = 640;   // probe: side of a slice, 128 to 4096
  int cell_px = 200;    // atlas: side of a slice, 64 to 1024
  int level_px = 1600;  // top view: longer side of the map, 256 to 8192
};

// Three slices through one probe, normal to the axes: the function, validity, the border of what the probe sees, the geometry's
// cut, the support points near the plane; beside them position, spacing, flags, shares.
// probe_idx   row of the shard's arrays
void viewProbe(const std::string& shard_path, uint64_t probe_idx, const ViewOptions& options, const std::string& out_path);

// 64 functions drawn at random (all, when there are fewer) in order of their index: of each the slice that differs most from the
// bare tent.
void viewAtlas(const std::string& shard_path, const ViewOptions& options, const std::string& out_path);

// The level from above, cut open at one height, with the probes that gave functions. Needs the scene: without it only the probes
// are drawn.
void viewTop(const std::string& shard_path, const ViewOptions& options, const std::string& out_path);

}  // namespace nlg
