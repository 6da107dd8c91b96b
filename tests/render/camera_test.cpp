#include "render/camera.h"

#include <gtest/gtest.h>

namespace nlg {
namespace {

constexpr double kRightAngle = 1.5707963267948966;

void expectNear(const glm::vec3& got, const glm::vec3& expected) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(got[axis], expected[axis], 1e-6f) << "axis " << axis;
}

// At a right angle from edge to edge, a point one ahead and one up stands on the upper edge; with an aspect of 2 one that is two to
// the right on the right edge.
TEST(Camera, KnownPointsLandOnTheEdges) {
  const Camera camera = cameraAlong(glm::dvec3(0.0), {0, 0, -1}, kRightAngle);
  expectNear(camera.direction(0.5, 0.0, 2.0), glm::normalize(glm::vec3(0, 1, -1)));
  expectNear(camera.direction(0.5, 1.0, 2.0), glm::normalize(glm::vec3(0, -1, -1)));
  expectNear(camera.direction(1.0, 0.5, 2.0), glm::normalize(glm::vec3(2, 0, -1)));
  expectNear(camera.direction(0.25, 0.25, 2.0), glm::normalize(glm::vec3(-1, 0.5, -1)));
}

TEST(Camera, StandsUprightWhereverItLooks) {
  for (const glm::dvec3& way : {glm::dvec3(1, 0.3, 0), glm::dvec3(-2, -5, 1), glm::dvec3(0, 0.01, 3)}) {
    const Camera camera = cameraAlong(glm::dvec3(0.0), way, 1.0);
    EXPECT_GT(camera.up.y, 0.0f);
    EXPECT_NEAR(glm::dot(camera.up, camera.forward), 0.0f, 1e-6f);
    EXPECT_NEAR(glm::length(camera.up), 1.0f, 1e-6f);
    // the picture's right is level
    EXPECT_NEAR(glm::cross(camera.forward, camera.up).y, 0.0f, 1e-6f);
  }
}

TEST(Camera, SeesAPointWhereItsRayGoes) {
  const Camera camera = cameraAlong({1, 2, 3}, {3, -1, 2}, 1.1);
  for (const glm::dvec2& place : {glm::dvec2(0.5, 0.5), glm::dvec2(0.1, 0.8), glm::dvec2(1.3, -0.2)}) {
    const auto seen = camera.seenAt(camera.eye_m + 4.0 * glm::dvec3(camera.direction(place.x, place.y, 1.7)), 1.7);
    ASSERT_TRUE(seen.has_value());
    // directions are rounded to float
    EXPECT_NEAR(seen->x, place.x, 1e-6);
    EXPECT_NEAR(seen->y, place.y, 1e-6);
  }
  EXPECT_FALSE(camera.seenAt(camera.eye_m - glm::dvec3(camera.forward), 1.7).has_value());
}

}  // namespace
}  // namespace nlg
