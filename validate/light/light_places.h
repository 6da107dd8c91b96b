// Sample points of a scene, in air with normals, at which light is measured: the same for all methods and spacings.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/probes/probe_placement.h"
#include "datagen/visibility/ray_scene.h"
#include "scene/model/scene.h"

namespace nlg {

// Places before surfaces are told apart by the distance to the surface that they were drawn from, metres: class i lies between
// borders i and i + 1, distances uniform in it.
inline constexpr std::array<double, 5> kSurfaceBordersM = {0.02, 0.05, 0.1, 0.2, 0.5};
inline constexpr int kSurfaceClassCount = kSurfaceBordersM.size() - 1;
inline constexpr int kFirstFarClass = 1;  // from 5 cm on: what sums over places before surfaces are made of

enum class PlaceGroup : uint8_t {
  air,      // uniform in the volume, any normal
  surface,  // before a surface, with its normal
  turned,   // those from 5 cm on, with any normal
  walk,     // steps of straight walks, one normal a walk
  edge,     // under a roof, 2 cm before a surface with its normal and 1 to 10 cm from another that stands across it
  corner,   // the same, and 1 to 10 cm from a third that stands across both
};
inline constexpr double kEdgeOffM = 0.02, kEdgeLowM = 0.01, kEdgeHighM = 0.1;

struct LightPlace {
  glm::dvec3 position_m{0.0};  // relative to the scene's origin
  glm::vec3 normal{0.0f, 1.0f, 0.0f};
  PlaceGroup group = PlaceGroup::air;
  uint8_t surface_class = 0;  // of surface and turned
  uint32_t room = 0;          // number of its room, LightPlaces::room_count for none; none of walks
  uint32_t walk = 0;          // number of the walk; its steps follow one another in the list
};

struct LightPlaceOptions {
  uint64_t air = 2000;
  uint64_t surface = 1600;  // a quarter of them in each class
  uint64_t walks = 40;
  int walk_steps = 64;        // at most: a walk ends where a surface stands in its way
  int least_walk_steps = 16;  // shorter ones are drawn anew
  double step_m = 1.0 / 16.0;
  uint64_t edges = 400;  // and as many corners. Where a sun shines on the place itself there is none: its patches have sharp rims
  uint64_t draws = 400000;  // of a place, at most, over all: scenes with little air get fewer places
  // Places nearer than this to a lamp or a face that shines are left out (and counted): light falls off there within less than any
  // probes are apart, and squares of errors would tell of those places alone. Shares of the scene's diagonal bound it.
  double source_distance_m = 1.0;
  uint64_t seed = 1;
};

inline constexpr double kSourceDiagonalShare = 0.04;  // of the scene's diagonal: source_distance_m is at most as much
inline constexpr float kSourceShare = 0.05;           // of the brightest face's radiance: what shines less is no source

struct LightPlaces {
  std::vector<LightPlace> places;  // air, surface, turned, walks, edges, corners
  uint64_t drawn = 0, in_air = 0;  // of the draws in the volume
  uint64_t near_source = 0;        // draws in air that were left out for it
  double source_distance_m = 0.0;  // as it was bounded
  std::array<uint64_t, kSurfaceClassCount> surface_count{};
  uint64_t walk_count = 0, edge_count = 0, corner_count = 0;
  uint32_t room_count = 0;  // 0: they are not parted into rooms

  // How often a place of this class counts in sums over distances from 5 to 50 cm: they add up to 1 over each of the groups
  // surface and turned.
  double surfaceWeight(uint8_t surface_class) const;
};

// All places are in air (light/air.h) and in the extent; between a place and the surface that it stands before there is
// nothing, nor between two steps of a walk. The same seed gives the same places.
LightPlaces drawLightPlaces(const Scene& scene, const RayScene& rays, const ExtentBox& extent, const LightPlaceOptions& options);

// Numbers the rooms of all places but walks', by the sight of those in air (validate/light/rooms.h).
void partIntoRooms(LightPlaces* places, const RayScene& rays, int threads);

}  // namespace nlg
