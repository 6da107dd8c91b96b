#include "scene/solid/triangle_distance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nlg {
namespace {

TEST(DistanceToTriangle, EqualsClosedForms) {
  const glm::vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  EXPECT_FLOAT_EQ(distanceToTriangle({1, 1, -2}, a, b, c), 2.0f);            // over its inside
  EXPECT_FLOAT_EQ(distanceToTriangle({1, 1, 0}, a, b, c), 0.0f);             // in it
  EXPECT_FLOAT_EQ(distanceToTriangle({2, -3, 0}, a, b, c), 3.0f);            // beside an edge
  EXPECT_FLOAT_EQ(distanceToTriangle({4, 4, 1}, a, b, c), std::sqrt(9.0f));  // beside the long one: √8 in its plane, 1 over it
  EXPECT_FLOAT_EQ(distanceToTriangle({-3, -4, 12}, a, b, c), 13.0f);         // at a corner
  EXPECT_FLOAT_EQ(distanceToTriangle({2, 5, 0}, a, b, {2, 0, 0}), 5.0f);     // a needle
  EXPECT_FLOAT_EQ(distanceToTriangle({3, 4, 0}, a, a, a), 5.0f);             // a point
}

}  // namespace
}  // namespace nlg
