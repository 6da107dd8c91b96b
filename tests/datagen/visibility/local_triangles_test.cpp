#include "datagen/visibility/local_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "datagen/visibility/segment_kernel.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// A triangle cut by the six planes of a cube, in double (Sutherland & Hodgman 1974): does anything remain?
bool touchesCube(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double half_side) {
  std::vector<glm::dvec3> polygon = {a, b, c};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      std::vector<glm::dvec3> kept;
      for (size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double dp = half_side - sign * p[axis], dq = half_side - sign * q[axis];
        if (dp >= 0) kept.push_back(p);
        if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) kept.push_back(p + (q - p) * (dp / (dp - dq)));
      }
      polygon = kept;
    }
  }
  return !polygon.empty();
}

glm::vec3 randomPoint(Random& random, double size) {
  return glm::vec3(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
}

std::vector<LocalTriangle> collected(const std::vector<glm::vec3>& corners, const glm::dvec3& position_m, double spacing_m) {
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> candidates;
  for (uint32_t i = 0; i + 2 < corners.size(); i += 3) {
    triangles.push_back({i, i + 1, i + 2});
    candidates.push_back(i / 3);
  }
  std::vector<LocalTriangle> result;
  collectLocalTriangles(corners, triangles, candidates, position_m, spacing_m, &result);
  return result;
}

TEST(LocalTriangles, AreThoseThatClippingFindsInTheSupport) {
  Random random(5);
  int touching = 0;
  for (int i = 0; i < 20000; ++i) {
    const double size = i % 2 ? 0.3 : 3.0, spacing = random.uniform(0.3, 1.2);
    const glm::vec3 a = randomPoint(random, 2), b = a + randomPoint(random, size), c = a + randomPoint(random, size);
    const glm::dvec3 position = randomPoint(random, 0.5);
    const auto clipped = [&](double half) {
      return touchesCube(glm::dvec3(a) - position, glm::dvec3(b) - position, glm::dvec3(c) - position, half * spacing);
    };
    // between touching and kBoxMargin clear, either answer is right
    const bool expected = clipped(1.0);
    if (expected != clipped(1.0 + 2 * kBoxMargin)) continue;
    touching += expected;
    ASSERT_EQ(collected({a, b, c}, position, spacing).size(), expected ? 1u : 0u) << "triangle " << i;
  }
  EXPECT_TRUE(touching > 2500 && touching < 17500) << touching;
}

TEST(SegmentMeets, AgreesWithExactGeometryAwayFromTies) {
  Random random(11);
  int met = 0, decided = 0;
  for (int i = 0; i < 200000; ++i) {
    const double size = i % 3 == 0 ? 0.2 : i % 3 == 1 ? 2.0 : 400.0;
    const glm::vec3 a = randomPoint(random, 1), b = a + randomPoint(random, size), c = a + randomPoint(random, size);
    const std::vector<LocalTriangle> triangles = collected({a, b, c}, glm::dvec3(0), 1);
    if (triangles.empty()) continue;
    const glm::vec3 p = randomPoint(random, 1), q = randomPoint(random, 1);
    // volumes in double; a tie is what rounding to float may turn
    const auto volume = [](glm::dvec3 u, glm::dvec3 v, glm::dvec3 w) { return glm::dot(u, glm::cross(v, w)); };
    const glm::dvec3 A(a), B(b), C(c), P(p), Q(q), normal = glm::normalize(glm::cross(B - A, C - A));
    const double from_side = glm::dot(normal, P - A), to_side = glm::dot(normal, Q - A);
    const double edges[3] = {volume(Q - P, A - P, B - P) / glm::length(B - A), volume(Q - P, B - P, C - P) / glm::length(C - B),
                             volume(Q - P, C - P, A - P) / glm::length(A - C)};
    bool tie = std::fabs(from_side) < 1e-5 || std::fabs(to_side) < 1e-5;
    for (const double edge : edges) tie |= std::fabs(edge) < 1e-5 * std::fabs(from_side - to_side);
    if (tie) continue;
    const bool inside = (edges[0] > 0 && edges[1] > 0 && edges[2] > 0) || (edges[0] < 0 && edges[1] < 0 && edges[2] < 0);
    const bool expected = inside && from_side * to_side < 0;
    ++decided, met += expected;
    ASSERT_EQ(segmentMeets(triangles[0], {p.x, p.y, p.z}, {q.x, q.y, q.z}), expected) << "case " << i << ", size " << size;
    ASSERT_EQ(segmentMeets(triangles[0], {q.x, q.y, q.z}, {p.x, p.y, p.z}), expected) << "case " << i << ", from the other end";
  }
  EXPECT_GT(decided, 50000);
  EXPECT_GT(met, 2000);
}

TEST(SegmentMeets, LetsNothingThroughBetweenNeighbours) {
  // fans of thin triangles round a point, near and far from the origin: segments straight through shared edges and corners
  Random random(3);
  for (int fan = 0; fan < 300; ++fan) {
    const double far = fan % 3 == 0 ? 0.0 : fan % 3 == 1 ? 1e3 : 1e5;  // metres; float spaces them by up to 8 mm
    const glm::dvec3 position = glm::dvec3(randomPoint(random, 1)) * far;
    const glm::vec3 center = glm::vec3(position) + randomPoint(random, 0.3);
    const int side_count = 3 + fan % 40;
    std::vector<glm::vec3> rim, corners;
    for (int i = 0; i < side_count; ++i) {
      const double angle = 6.283185307 * i / side_count;
      rim.push_back(center + glm::vec3(2 * std::cos(angle), 2 * std::sin(angle), random.uniform(-0.4, 0.4)));
    }
    for (int i = 0; i < side_count; ++i) {
      for (const glm::vec3& corner : {center, rim[i], rim[(i + 1) % side_count]}) corners.push_back(corner);
    }
    const std::vector<LocalTriangle> triangles = collected(corners, position, 1);
    for (int i = 0; i < side_count; ++i) {
      const glm::dvec3 hub = glm::dvec3(center) - position, spoke = glm::dvec3(rim[i]) - position;
      for (const double share : {0.0, 0.1, 0.37}) {
        const glm::dvec3 at = glm::mix(hub, spoke, share);
        if (glm::any(glm::greaterThan(glm::abs(at), glm::dvec3(0.9)))) continue;
        // straight down: every face of the fan is crossed from above to below
        const LocalPoint above = {float(at.x), float(at.y), float(at.z) + 0.5f},
                         below = {float(at.x), float(at.y), float(at.z) - 0.5f};
        const bool stopped = std::any_of(triangles.begin(), triangles.end(),
                                         [&](const LocalTriangle& t) { return segmentMeets(t, above, below); });
        ASSERT_TRUE(stopped) << "fan " << fan << ", spoke " << i << ", share " << share;
      }
    }
  }
}

}  // namespace
}  // namespace nlg
