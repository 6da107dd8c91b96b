#include "light/methods/ddgi.h"

#include <gtest/gtest.h>

#include "runtime_eval/numbers/random.h"
#include "tests/validate/light/lit_scenes.h"

namespace nlg {
namespace {

TEST(OctahedralMap, GoesOnBeyondItsRimWithTheNextDirections) {
  OctahedralMap<glm::vec3, 14> map;
  for (int texel = 0; texel < map.kTexelCount; ++texel) map.texels[texel] = map.direction(texel);
  // the widest step inside the map
  const auto step = [&](int x, int y, int next_x, int next_y) {
    return glm::distance(map.wrapped(x, y), map.wrapped(next_x, next_y));
  };
  float widest = 0.0f;
  for (int i = 0; i < 13; ++i) {
    for (int k = 0; k < 14; ++k) widest = std::max({widest, step(i, k, i + 1, k), step(k, i, k, i + 1)});
  }
  for (int k = 0; k < 14; ++k) {
    EXPECT_LE(step(0, k, -1, k), widest);
    EXPECT_LE(step(13, k, 14, k), widest);
    EXPECT_LE(step(k, 0, k, -1), widest);
    EXPECT_LE(step(k, 13, k, 14), widest);
  }
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 direction =
        glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) + glm::vec3(1e-6f));
    // a blend of texels that are all within a step and a half
    EXPECT_LE(glm::distance(map.at(direction), direction), 1.5f * widest);
  }
}

// Probes 1 m apart with nothing near: their depth is the longest that is stored.
class DdgiTest : public testing::Test {
 protected:
  DdgiTest() : lit_(brightAndDarkRoom()) {}
  static DdgiProbe probeAt(const glm::dvec3& position_m, float depth, float squared_depth) {
    DdgiProbe probe;
    probe.position_m = position_m;
    probe.is_active = true;
    probe.depth.texels.fill({depth, squared_depth});
    return probe;
  }
  LitScene lit_;
  ProbeSet probes_;
  DdgiMaps maps_;
};

TEST_F(DdgiTest, WeighsASeenProbeByItsNormalAlone) {
  const Ddgi ddgi(probes_, maps_);
  const DdgiProbe probe = probeAt({0, 1, 0}, 2.5f, 6.25f);
  // straight ahead: ((1 + 1) / 2)² + .2; aside: (1/2)² + .2; behind: .2, which is where weights begin to be crushed
  EXPECT_NEAR(ddgi.probeWeight(probe, glm::dvec3(0), glm::dvec3(0), {0, 1, 0}), 1.2f, 1e-5f);
  EXPECT_NEAR(ddgi.probeWeight(probe, glm::dvec3(0), glm::dvec3(0), {1, 0, 0}), 0.45f, 1e-5f);
  EXPECT_NEAR(ddgi.probeWeight(probe, glm::dvec3(0), glm::dvec3(0), {0, -1, 0}), 0.2f, 1e-5f);
}

TEST_F(DdgiTest, WeighsAnOccludedProbeByChebyshevsBound) {
  const Ddgi ddgi(probes_, maps_);
  // mean .8, variance .04; at 1 m: .04 / (.04 + .2²) = 1/2, cubed 1/8, times 1.2: .15, crushed to .15³ / .2²
  EXPECT_NEAR(ddgi.probeWeight(probeAt({0, 1, 0}, 0.8f, 0.68f), glm::dvec3(0), glm::dvec3(0), {0, 1, 0}), 0.084375f, 1e-4f);
  // hidden by far: .05 of 1.2 is .06, crushed to .06³ / .2²
  EXPECT_NEAR(ddgi.probeWeight(probeAt({0, 1, 0}, 0.1f, 0.01f), glm::dvec3(0), glm::dvec3(0), {0, 1, 0}), 0.0054f, 1e-5f);
}

TEST_F(DdgiTest, MovesProbesOffSurfacesAndOutOfSolid) {
  const auto stand = [&](const glm::dvec3& position_m) {
    ProbeSet probes;
    probes.position_m = {position_m};
    probes.spacing_m = {1.0f};
    DdgiMapsOptions options;
    options.gather.rays = 256;
    options.relocates = true;
    return makeDdgiMaps(probes, lit_.transport, options).probes[0];
  };
  const DdgiProbe near_wall = stand({0.3, 1.5, 1.5}), in_wall = stand({0.4, 1.5, 1.5}), free = stand({-1.0, 1.5, 1.5});
  // a step of a third of the spacing away from the wall, towards the farthest corner of the room: a part of it along x
  EXPECT_LT(near_wall.position_m.x, kWallLow - 0.15);
  EXPECT_TRUE(near_wall.is_active);
  EXPECT_TRUE(in_wall.position_m.x < kWallLow || in_wall.position_m.x > kWallHigh);
  EXPECT_TRUE(in_wall.is_active);
  EXPECT_EQ(free.position_m, glm::dvec3(-1.0, 1.5, 1.5));
}

// In a room of walls that look outward: by RTXGI's own rule all are backs.
TEST(Ddgi, TakesTheBackOfADoubleSidedFaceForAFrontIfAskedTo) {
  SceneOfFaces faces;
  faces.addBox({-2, -2, -2}, {2, 2, 2});
  Scene scene = faces.finish();
  for (const bool double_sided : {false, true}) {
    for (Material& material : scene.materials) material.double_sided = double_sided;
    const LitScene lit(scene);
    EXPECT_EQ(hasSheets(lit.scene), double_sided);
    ProbeSet probes;
    probes.position_m = {glm::dvec3(0.0)};
    probes.spacing_m = {4.0f};
    for (const SheetBacks backs : {SheetBacks::as_wound, SheetBacks::none}) {
      DdgiMapsOptions options;
      options.gather = {256, 8};
      options.backs = backs;
      const DdgiProbe probe = makeDdgiMaps(probes, lit.transport, options).probes[0];
      const bool is_front = double_sided && backs == SheetBacks::none;
      EXPECT_EQ(probe.is_active, is_front);
      if (!is_front) continue;
      // along an axis 2 m, and a little more a little beside it
      EXPECT_NEAR(probe.depth.at({1, 0, 0}).x, 2.0f, 0.1f);
    }
  }
}

TEST(Ddgi, IsMeasuredByBothRulesWhereTheyDiffer) {
  Scene scene = brightAndDarkRoom();
  for (const bool double_sided : {false, true}) {
    scene.materials[0].double_sided = double_sided;
    const LitScene lit(scene);
    MethodSet methods = lit.methods();
    methods.addDdgi({LightWay::point});
    std::vector<std::string> names;
    for (const LightMethod& method : methods.methods()) names.push_back(method.weights);
    std::vector<std::string> expected = {"DDGI as shipped", "DDGI as shipped, relocated"};
    if (double_sided)
      expected.insert(expected.end(), {"DDGI as shipped, backless sheets", "DDGI as shipped, backless sheets, relocated"});
    EXPECT_EQ(names, expected);
  }
}

TEST_F(DdgiTest, LosesLittleToTenBits) {
  DdgiMaps maps;
  maps.probes.resize(2);
  maps.probes[0].irradiance.texels.fill(glm::vec3(1.7f));  // over 2 pi, to the power of 1/5
  maps.probes[1].irradiance.texels.fill(glm::vec3(0.9f));
  const DdgiMaps shipped = asShipped(maps);
  EXPECT_NEAR(shipped.scale, std::pow(1.7f, 5.0f), 1e-3f);
  for (size_t p = 0; p < 2; ++p) {
    const float stored = shipped.probes[p].irradiance.texels[0].r * 1.7f;
    EXPECT_NEAR(stored, maps.probes[p].irradiance.texels[0].r, 0.5f * 1.7f / 1023.0f + 1e-6f);
  }
}

}  // namespace
}  // namespace nlg
