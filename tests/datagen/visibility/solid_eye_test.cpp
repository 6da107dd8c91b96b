#include "datagen/visibility/solid_eye.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "datagen/visibility/solid_vote.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/runtime_eval/each_target.h"

namespace nlg {
namespace {

const std::vector<LocalPoint>& points() { return supportPattern().points; }

LocalPoint eyeAt(const Scene& scene, const glm::dvec3& position_m) {
  const RayScene rays(scene);
  SupportVisibility visibility(rays);
  visibility.beginProbe(position_m, 1.0f);
  return SolidEye().open(&visibility).value();
}

// A wall between two rooms, thick, the probe inside it nearer to the one at x < 0.
Scene wallBetweenRooms() { return SceneOfFaces().addBox({-0.15f, -50, -50}, {0.35f, 50, 50}).finish(); }

TEST(SolidEye, IsOnTheNearerSideOfAWall) { EXPECT_LT(eyeAt(wallBetweenRooms(), {0, 0.01, 0.02})[0], -0.15f); }

TEST(SolidEye, IsInTheLargerOfTwoRoomsEvenFartherAway) {
  // a cupboard right beside the probe, and a hall twice as far away
  SceneOfFaces faces;
  faces.addBox({-0.7f, -0.3f, -0.3f}, {-0.05f, 0.3f, 0.3f}, true);
  faces.addQuad({0.1f, -50, -50}, {0.1f, 50, -50}, {0.1f, 50, 50}, {0.1f, -50, 50});
  EXPECT_GT(eyeAt(faces.finish(), {0, 0, 0})[0], 0.1f);
}

TEST(SolidEye, IsNotBehindTheSky) {
  // ground between two levels of air, the lower one under a sky that closes it off from below
  Scene scene = SceneOfFaces().addBox({-50, -0.1f, -50}, {50, 0.3f, 50}).finish();
  EXPECT_LT(eyeAt(scene, {0, 0, 0})[1], -0.1f);
  scene.light.sky_faces.positions = {{-50, -0.1005f, -50}, {50, -0.1005f, -50}, {50, -0.1005f, 50}, {-50, -0.1005f, 50}};
  scene.light.sky_faces.triangles = {{0, 2, 1}, {0, 3, 2}};
  EXPECT_GT(eyeAt(scene, {0, 0, 0})[1], 0.3f);
}

// In the window both sides of the wall are seen, on one side of it hardly more than that side.
TEST(SolidEye, IsOnOneSideOfAWallAndNotInItsWindow) {
  SceneOfFaces faces;
  const float from = -0.1f, to = 0.1f;
  faces.addBox({from, -50, -50}, {to, -1.2f, 50});
  faces.addBox({from, 0.0f, -50}, {to, 50, 50});
  faces.addBox({from, -1.2f, -50}, {to, 0.0f, -0.6f});
  faces.addBox({from, -1.2f, 0.6f}, {to, 0.0f, 50});
  EXPECT_GT(std::abs(eyeAt(faces.finish(), {0.05, 0.03, 0.2})[0] + 0.05f), to);
}

TEST(SolidEye, SeesAtLeastAsMuchAsTheCandidateThatSeesMostOthers) {
  const Scene scene = wallBetweenRooms();  // all that an eye sees of it sees each other, too
  const RayScene rays(scene);
  SupportVisibility visibility(rays);
  for (const glm::dvec3& position : {glm::dvec3(0.02, 0.03, 0.01), glm::dvec3(0.4, -0.3, 0.2), glm::dvec3(0.4, -0.6, -0.35)}) {
    visibility.beginProbe(position, 1.0f);
    const auto isAir = [&](uint32_t point) {
      const LocalPoint& at = points()[point];
      return !voteAt(rays, position + glm::dvec3(at[0], at[1], at[2])).solid();
    };
    const auto seenTents = [&](const LocalPoint& from, const auto& of) {
      double sum = 0.0;
      for (const uint32_t point : of) {
        const LocalPoint& to = points()[point];
        if (visibility.isOpen(from, to)) sum += double{tent(to)};
      }
      return sum;
    };
    std::vector<uint32_t> air;
    const std::vector<uint32_t>& inner = eyeCandidates(EyeRing::inner);
    std::copy_if(inner.begin(), inner.end(), std::back_inserter(air), isAir);
    const auto best = std::max_element(air.begin(), air.end(), [&](uint32_t a, uint32_t b) {
      return seenTents(points()[a], air) < seenTents(points()[b], air);
    });
    std::vector<uint32_t> all(kSupportPointCount);
    std::iota(all.begin(), all.end(), 0u);
    const double most = best == air.end() ? 0.0 : seenTents(points()[*best], all);
    forEachTarget([&] {
      const auto eye = SolidEye().open(&visibility);
      ASSERT_EQ(eye.has_value(), !air.empty());
      if (!eye) return;
      EXPECT_EQ(visibility.eye(), *eye);
      // tents are rounded to 2^-32 each
      EXPECT_GE(seenTents(*eye, all), most - kSupportPointCount * 0x1p-32);
    });
  }
}

}  // namespace
}  // namespace nlg
