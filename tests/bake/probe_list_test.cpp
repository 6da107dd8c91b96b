// The table of probes: a row for each, in its place.
#include "bake/probe_list.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

TEST(ProbeTable, HoldsThePlaceKindAndMeanRadianceOfEveryProbe) {
  LightGrid grid = litGrid(randomTree(3).tree, 3);
  grid.probe_function[0] = kNoWeight;
  grid.probe_function[1] = kFreeSpace;
  grid.probe_function[2] = 0;
  std::istringstream table(probeTable(grid));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "x_m,y_m,z_m,kind,r,g,b");
  for (size_t p = 0; p < grid.tree.probeCount(); ++p) {
    ASSERT_TRUE(std::getline(table, line)) << p;
    PositionM at{};
    char kind[16] = {};
    float rgb[3] = {};
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%15[a-z],%f,%f,%f", &at[0], &at[1], &at[2], kind, &rgb[0], &rgb[1], &rgb[2]),
              7)
        << line;
    const PositionM expected = grid.tree.probePosition(p);
    for (size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(at[axis], expected[axis], 1e-8 * std::abs(expected[axis])) << line;
    // radiance of 1 all around has the coefficient sqrt(4 pi)
    for (size_t c = 0; c < 3; ++c) {
      const double mean = grid.probeLight(p)[c] / std::sqrt(4.0 * 3.14159265358979);
      EXPECT_NEAR(rgb[c], mean, 1e-3 * std::abs(mean) + 1e-12) << line;
    }
    if (p < 3) {
      EXPECT_STREQ(kind, (std::array{"none", "tent", "function"})[p]);
    }
  }
  EXPECT_FALSE(std::getline(table, line)) << line;
}

TEST(ProbeTable, HasNoColumnsOfLightWhereTheGridHasNone) {
  LightGrid grid = litGrid(randomTree(3).tree, 3);
  grid.light.clear();
  EXPECT_EQ(probeTable(grid).substr(0, 17), "x_m,y_m,z_m,kind\n");
}

}  // namespace
}  // namespace nlg
