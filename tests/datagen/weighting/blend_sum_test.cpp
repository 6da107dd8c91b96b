#include "datagen/weighting/blend_sum.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datagen/weighting/weighting_builder.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

const LinkTable& table() {
  static const LinkTable links = makeLinkTable({});
  return links;
}

// The probe at the origin of a lattice a metre apart.
struct Summed {
  ProbeOutcome outcome;
  GeneratedFunction function;
  NeighbourEyes eyes;
  std::vector<uint8_t> sums = std::vector<uint8_t>(kSupportPointCount, 7);
};

ProbeTreeFrame lattice() {
  ProbeTreeFrame frame;
  frame.first_m = {-3.0, -3.0, -3.0};
  return frame;
}

Summed summed(const RayScene& rays) {
  ProbeEyes eyes(lattice());
  WeightingBuilder builder(rays, table(), {});
  Summed result;
  const std::optional<ProbeOutcome> settled = builder.begin(glm::dvec3(0.0), 1.0f, InSolid::by_eye, &eyes);
  result.outcome = settled ? *settled : builder.look();
  if (result.outcome != ProbeOutcome::function) return result;
  result.outcome = builder.generate(&result.function);
  builder.sumBlend(result.function, result.sums.data());
  result.eyes = builder.neighbours();
  return result;
}

std::vector<Scene> scenes() {
  SceneOfFaces room;
  room.addRoom({-0.4f, -0.5f, -0.6f}, {0.7f, 0.45f, 0.55f}, 0.2f);
  return {infiniteWall(),
          halfWall(),
          wallWithHole(),
          thinWall(Sides::two),
          slivers(),
          room.finish(),
          terrainSheet(-0.3f, Sides::one),
          crossingBoxes(),
          crateWithFin()};
}

TEST(BlendSum, IsTheShareOfTheProbesOnThisSideOfAWall) {
  const Scene scene = infiniteWall();  // from x = .31 to .47
  const RayScene rays(scene);
  const Summed got = summed(rays);
  ASSERT_EQ(got.outcome, ProbeOutcome::function);
  int before_the_wall = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& at = supportPattern().points[p];
    if (got.function.phi[p] == 0.0f) {
      ASSERT_EQ(got.sums[p], 255) << p;
      continue;
    }
    // of eight tents those of the four probes at x = 1 are missing
    const double expected = at[0] < 0.0f ? 1.0 : 1.0 - at[0];
    ASSERT_NEAR(got.sums[p], 255.0 * expected, 0.51) << "x = " << at[0];
    before_the_wall += at[0] > 0.0f;
  }
  EXPECT_GT(before_the_wall, 500);
}

// From the definition: a segment for every neighbour and point, against the triangles of the support one by one.
TEST(BlendSum, IsTheSumOfTentsThatEyesSee) {
  int partial = 0;
  for (const Scene& scene : scenes()) {
    const RayScene rays(scene);
    const Summed got = summed(rays);
    if (got.outcome != ProbeOutcome::function) continue;
    SupportVisibility visibility(rays, table());
    visibility.beginProbe(glm::dvec3(0.0), 1.0f);
    for (int p = 0; p < kSupportPointCount; p += 3) {
      if (got.function.phi[p] == 0.0f) continue;
      const LocalPoint& at = supportPattern().points[p];
      double sum = got.function.phi[p];
      for (int n = 0; n < 27; ++n) {
        const int offset[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
        if (n == 13 || !got.eyes[n]) continue;
        double theirs = 1.0;
        LocalPoint eye;
        for (int axis = 0; axis < 3; ++axis) {
          theirs *= std::max(0.0, 1.0 - std::fabs(double{at[axis]} - offset[axis]));
          eye[axis] = static_cast<float>(offset[axis]) + (*got.eyes[n])[axis];
        }
        if (theirs > 0.0 && visibility.isOpen(eye, at)) sum += theirs;
      }
      ASSERT_NEAR(got.sums[p], 255.0 * std::min(1.0, sum), 0.51) << "point " << p;
      partial += sum < 0.99;
    }
  }
  EXPECT_GT(partial, 1000);
}

}  // namespace
}  // namespace nlg
