// Sample points in air for each cell of a probe tree, at which light is measured; and the cells and probes that have no air.
//
// Half and more of a real level's cells lie wholly in solid. Nothing is ever looked up in them: they are left out of the tree,
// and with them the probes that no other cell reads. Every probe that is left is live.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/visibility/ray_scene.h"
#include "nlg/probe_tree.h"

namespace nlg {

struct AirPlaceOptions {
  int places_per_cell = 12;  // kept at most
  int draws_per_cell = 48;   // at most, until as many places are found
  int draws_for_one = 192;   // at most, until the first one is: a slab of air 3 cm high is a thirtieth of a cell of 1 m
  uint64_t seed = 1;
  // treeOfAir of the same tree, from an earlier search, in any coordinates: cells that it lacks are not searched again
  const ProbeTree* known = nullptr;
};

struct AirPlaces {
  struct Cell {
    ProbeCell cell;
    uint32_t first = 0, count = 0;  // of its places; a cell without any holds no air that was found
    double air_share = 0.0;         // of the places drawn
  };
  std::vector<Cell> cells;         // all cells of the tree, in its order
  std::vector<glm::dvec3> places;  // relative to the scene's origin, in the order of cells
  uint64_t drawn = 0, votes = 0;   // places drawn, and those of them that rays had to vote about
  uint64_t in_cavities = 0;        // of those drawn: cavity.h
  double spacing_m = 0.0;          // of the tree; a bake puts that outside boxes with a spacing of their own in its place
};

// Draws evenly spread places in every cell. A place is in air where isInAir says so (air.h); what sees a place that is known
// to be in air, in solid or in a cavity, is what that place is.
//
// tree   in the scene's coordinates
// The same places for any number of threads.
AirPlaces findAirPlaces(const RayScene& rays, const ProbeTree& tree, const AirPlaceOptions& options, int thread_count);

// The same tree without cells that hold no air.
ProbeTree treeOfAir(const ProbeTree& tree, const AirPlaces& air);

}  // namespace nlg
