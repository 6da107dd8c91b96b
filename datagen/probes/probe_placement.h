// Places the probes of a scene: a tree over its extent, dense near geometry.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datagen/probes/nearby_triangles.h"
#include "nlg/probe_tree.h"
#include "scene/model/scene.h"

namespace nlg {

struct ProbePlacementOptions {
  double spacing_min_m = 0.7;  // the finest distance between probes; each jitter draws its own, uniform in the logarithm
  double spacing_max_m = 2.2;
  double density_growth = 0.5;  // a cell may be as large as this times its distance from the nearest triangle; 0: all are finest
  bool align_lattice =
      false;  // no shift: the extent's low corner is a probe, and so is its high corner where whole spacings end there
  std::optional<ExtentBox> extent;       // where positions have probes; none: the scene's own, or its bounds
  std::vector<DensityBox> density;       // world coordinates, as of Scene: 0 wins over all, the least spacing over others
  std::optional<ExtentBox> reach;        // what the scene's bounds are widened to hold where they are the extent
  uint64_t max_probes = kMaxTreeProbes;  // a scene and spacing that need more are refused
};

// The extent from the six numbers of a setting: low x, y, z, high x, y, z, metres, world coordinates; none when there are none.
// throws   UsageError naming extent_m unless they are six finite numbers with low <= high
std::optional<ExtentBox> extentFromNumbers(const std::vector<std::string>& numbers);

// What the tree below covers at least, relative to the scene's origin.
ExtentBox probeExtent(const Scene& scene, const ProbePlacementOptions& options);

// A finest spacing for who names none: half a metre, which rooms are well lit with, or the root of half where that takes more than
// kManyProbes; else a metre, and more where that takes more than kMostChosenProbes. Finer for what is smaller than four metres.
// options   but for their spacing and boxes
struct ChosenSpacing {
  double spacing_m = 1.0, probes = 0.0;             // as estimated
  double coarser_m = 0.0, probes_of_coarser = 0.0;  // what the next coarser one would take
  double finer_m = 0.0, probes_of_finer = 0.0;      // … and the next finer one
};
inline constexpr double kManyProbes = 12000, kMostChosenProbes = 200000;
ChosenSpacing chooseSpacing(const NearbyTriangles& nearby, ProbePlacementOptions options);

// What became of boxes with a spacing of their own.
struct PlacedBoxes {
  size_t inside = 0;                 // that reach into the extent
  std::vector<std::string> outside;  // nodes of the others
};

// The tree over the extent, its frame relative to the scene's origin. The finest spacing, and the shift of the lattice by up to
// one root node (none with align_lattice), are drawn from seed; the tree is a pure function of (scene, options, seed), the same on every machine.
//
// Every position in the extent has probes; so has what else lies in a cell that reaches into it. Along an axis where the scene's
// bounds are thinner than a spacing the extent reaches one spacing beyond them on both sides. A scene without triangles has an
// empty tree when no extent is given, and one of the largest cells when it is. With density_growth <= 1/sqrt(3) a probe with a
// triangle in its support always has the finest spacing (docs/theory/probes.md).
//
// The spacing of a box is rounded to the nearest power of two times that elsewhere. The lattice has the finest; cells outside keep to the
// spacing. In a box cells are as large as it allows, whatever is near; cells that also reach out of it are no larger than elsewhere. An
// estimate counts what several fine boxes share for each.
//
// boxes    receives what became of options.density; may be null
// throws   UsageError when an option lies outside its range, when a box asks for less than a 32nd of the spacing, or when the tree
//          would hold more than max_probes probes (it names a spacing that fits; what is far too much is refused by an estimate, without
//          building it) or reach over more than kMaxLatticeSide spacings
ProbeTree placeProbes(const NearbyTriangles& nearby, const ProbePlacementOptions& options, uint64_t seed,
                      PlacedBoxes* boxes = nullptr);

}  // namespace nlg
