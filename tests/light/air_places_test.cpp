#include "light/air_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "datagen/probes/probe_placement.h"
#include "light/air.h"
#include "scene/procedural/procedural.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

struct Surveyed {
  explicit Surveyed(Scene s, double spacing_m = 1.0, int threads = 2) : scene(std::move(s)), rays(scene) {
    ProbePlacementOptions options;
    options.spacing_min_m = options.spacing_max_m = spacing_m;
    full = placeProbes(scene, options, 1);
    air = findAirPlaces(rays, full, {}, threads);
    tree = treeOfAir(full, air);
  }
  Scene scene;
  RayScene rays;
  ProbeTree full, tree;
  AirPlaces air;
};

Scene thickRoom() {
  SceneOfFaces faces;
  faces.addRoom({-2.5f, -1.5f, -2.5f}, {2.5f, 1.5f, 2.5f}, 6.0f);
  return faces.finish();
}

TEST(AirPlaces, LieInAirAndInTheirCells) {
  const Surveyed level(makeProceduralScene("house", 3));
  EXPECT_GT(level.air.places.size(), 1000u);
  for (const AirPlaces::Cell& cell : level.air.cells) {
    for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      const glm::dvec3& p = level.air.places[i];
      ProbesAround around;
      ASSERT_TRUE(level.full.lookUp({p.x, p.y, p.z}, &around));
      EXPECT_EQ(around.cell, cell.cell);
    }
  }
  size_t in_air = 0;
  for (const glm::dvec3& p : level.air.places) in_air += isInAir(level.rays, p);
  // what a place in air sees is taken for air without a vote of its own: votes about a few of them differ
  EXPECT_GT(in_air, 0.98 * static_cast<double>(level.air.places.size()));
}

TEST(AirPlaces, EveryProbeOfTheTreeOfAirIsRead) {
  const Surveyed level(thickRoom());
  std::set<uint32_t> read;
  for (const glm::dvec3& p : level.air.places) {
    ProbesAround around;
    ASSERT_TRUE(level.tree.lookUp({p.x, p.y, p.z}, &around));
    for (const ProbeAround& corner : around.corners) read.insert(corner.probe);
  }
  EXPECT_EQ(read.size(), level.tree.probeCount());
  // a cell that reaches into air has no corner deeper in the walls than its side along any axis
  for (size_t p = 0; p < level.tree.probeCount(); ++p) {
    const auto [x, y, z] = level.tree.probePosition(p);
    const double from_room = std::max({std::abs(x) - 2.5, std::abs(y) - 1.5, std::abs(z) - 2.5});
    const double from_outside = std::min({8.5 - std::abs(x), 7.5 - std::abs(y), 8.5 - std::abs(z)});
    EXPECT_LE(std::min(from_room, from_outside), static_cast<double>(level.tree.probeSpacing(p)) + 1e-9);
  }
}

}  // namespace
}  // namespace nlg
