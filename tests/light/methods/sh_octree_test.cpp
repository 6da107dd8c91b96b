#include "light/methods/sh_octree.h"

#include <gtest/gtest.h>

#include "tests/validate/light/lit_scenes.h"

namespace nlg {
namespace {

// The scene of two rooms with light that a test makes up, at many places.
class ShOctreeTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    lit_ = new LitScene(brightAndDarkRoom());
    AirPlaceOptions many;
    many.places_per_cell = 60;
    many.draws_per_cell = 240;
    many.seed = 7;
    places_ = new std::vector<glm::dvec3>(findAirPlaces(lit_->rays, lit_->tree, many, 2).places);
  }
  static void TearDownTestSuite() {
    delete places_;
    delete lit_;
  }

  template <class LightAt>
  std::vector<ShOctree> grown(const std::vector<size_t>& budgets, LightAt light_at, int threads = 2) const {
    std::vector<LightSh> light;
    for (const glm::dvec3& place : *places_) light.push_back(light_at(place));
    ShOctreeOptions options;
    options.byte_budgets = budgets;
    options.bytes = [](const ProbeTree& tree) { return 32 * tree.probeCount(); };
    options.thread_count = threads;
    return growShOctrees(lit_->transport, *places_, light, options);
  }
  static LightSh grey(float value) {
    LightSh light{};
    light[0] = glm::vec3(value);
    return light;
  }

  static LitScene* lit_;
  static std::vector<glm::dvec3>* places_;
};
LitScene* ShOctreeTest::lit_ = nullptr;
std::vector<glm::dvec3>* ShOctreeTest::places_ = nullptr;

TEST_F(ShOctreeTest, HasConstantLightWithoutError) {
  const std::vector<ShOctree> octrees = grown({4096}, [](const glm::dvec3&) { return grey(2.0f); });
  ASSERT_EQ(octrees.size(), 1u);
  const ShOctreeWeighting weighting(octrees[0].tree);
  const LightAt light_at = blendedLight(weighting, octrees[0].light);
  const glm::vec3 normal(0.0f, 1.0f, 0.0f), expected = irradiance(grey(2.0f), normal);
  for (const glm::dvec3& place : *places_) {
    const LightAnswer at = answerAt(light_at, {place, normal});
    ASSERT_EQ(at.reach, Reach::lit);
    // the solve ends at 1e-4 of its first residual
    EXPECT_NEAR(at.irradiance.g, expected.g, 1e-3 * expected.g);
  }
}

TEST_F(ShOctreeTest, PutsSmallCellsWhereLightChangesAndNotElsewhere) {
  // a border of light in the middle of the bright room, where no cell of 4 m has a face
  const auto light_at = [](const glm::dvec3& p) { return grey(p.x < -1.13 ? 4.0f : 1.0f); };
  const std::vector<ShOctree> octrees = grown({32 * 1500}, light_at);
  int32_t smallest = 64;
  double nearest_m = 0.0;
  octrees.back().tree.forEachCell([&](const ProbeCell& cell) { smallest = std::min(smallest, cell.side); });
  octrees.back().tree.forEachCell([&](const ProbeCell& cell) {
    if (cell.side > smallest) return;
    const double low = octrees.back().tree.frame().first_m[0] + kOctreeFinestM * cell.low[0];
    const double away = std::max({0.0, low + 1.13, -1.13 - low - kOctreeFinestM * cell.side});
    nearest_m = std::max(nearest_m, away);
  });
  EXPECT_LE(smallest, 2);  // of 50 cm
  // cells become small together in cubes of 1 m at least, one such cube beside the border at most
  EXPECT_LE(nearest_m, 2.0);
}

}  // namespace
}  // namespace nlg
