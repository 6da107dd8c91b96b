#include "scene/obj/polygon_cut.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

glm::dvec3 twiceArea(const std::vector<glm::dvec3>& corners, const glm::uvec3& t) {
  return glm::cross(corners[t.y] - corners[t.x], corners[t.z] - corners[t.x]);
}

// A flat outline in any plane, somewhere.
std::vector<glm::dvec3> placed(const std::vector<glm::dvec2>& outline, const glm::dvec3& x, const glm::dvec3& y,
                               const glm::dvec3& origin) {
  std::vector<glm::dvec3> corners;
  for (const glm::dvec2& p : outline) corners.push_back(origin + p.x * x + p.y * y);
  return corners;
}

// Every triangle looks where the outline does, and together they have its area: none lies on another then, nor outside.
void expectCovered(const std::vector<glm::dvec3>& corners, const glm::dvec3& facing, double area) {
  const PolygonCut cut = cutPolygon(corners);
  EXPECT_TRUE(cut.holds_area);
  double sum = 0.0;
  for (const glm::uvec3& t : cut.triangles) {
    const double part = 0.5 * glm::dot(twiceArea(corners, t), facing);
    EXPECT_GT(part, -1e-9 * area);
    sum += part;
  }
  EXPECT_NEAR(sum, area, 1e-6 * area);
}

double areaOf(const std::vector<glm::dvec2>& outline) {
  double twice = 0.0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * twice;
}

// From every first corner, in three planes, both ways round.
void expectCoveredHoweverItIsWritten(std::vector<glm::dvec2> outline) {
  const double area = areaOf(outline);
  ASSERT_GT(area, 0.0);
  for (size_t start = 0; start < outline.size(); ++start) {
    std::rotate(outline.begin(), outline.begin() + 1, outline.end());
    const glm::dvec3 slant = glm::normalize(glm::dvec3(1, 2, 3)), beside = glm::normalize(glm::cross(slant, glm::dvec3(0, 1, 0)));
    for (const auto& [x, y] :
         {std::pair(glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)), {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0)}, {slant, beside}}) {
      expectCovered(placed(outline, x, y, {500000.25, -3.0, 4649776.5}), glm::cross(x, y), area);
      std::vector<glm::dvec2> back(outline.rbegin(), outline.rend());
      expectCovered(placed(back, x, y, {0, 0, 0}), -glm::cross(x, y), area);
    }
  }
}

TEST(PolygonCut, CoversConcaveOutlinesAndLeavesHolesOpen) {
  // clang-format off
  const std::vector<std::vector<glm::dvec2>> outlines = {
      {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},                                                  // an L
      {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}},                                  // a U
      {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 3}, {1, 3}, {1, 1}, {0, 1}},                                  // a T
      {{0, 0}, {4, 0}, {4, 1}, {3, 1}, {3, 2}, {4, 2}, {4, 3}, {0, 3}, {0, 2}, {1, 2}, {1, 1}, {0, 1}},  // an H
      {{1, 0}, {2, 0}, {2, 1}, {3, 1}, {3, 2}, {2, 2}, {2, 3}, {1, 3}, {1, 2}, {0, 2}, {0, 1}, {1, 1}},  // a cross
      {{0, 0}, {2, 1}, {4, 0}, {2, 4}},                                                                  // an arrow
      {{0, 0}, {8, 0}, {8, 3}, {6, 3}, {6, 2.1}, {5, 2.1}, {5, 0.5}, {3, 0.5}, {3, 3}, {0, 3}},          // steps
      {{0, 0}, {3, 0}, {3, 2.1}, {4, 2.1}, {4, 0}, {8, 0}, {8, 3}, {0, 3}},                              // a door
      {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {3, 2}, {0, 2}, {0, 1}},                                  // corners on its edges
      {{0, 0}, {0, 0}, {4, 0}, {4, 4}, {4, 4}, {0, 4}},                                                  // corners twice
      // a wall with a window, to which a line leads and back; with two; a hole that touches a corner
      {{0, 0}, {8, 0}, {8, 3}, {0, 3}, {0, 0}, {3, 1}, {3, 2}, {5, 2}, {5, 1}, {3, 1}},
      {{0, 0}, {8, 0}, {8, 3}, {6, 2}, {6, 1}, {5, 1}, {5, 2}, {6, 2}, {8, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1},
       {1, 1}},
      {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 2}, {2, 1}}};
  // clang-format on
  for (size_t i = 0; i < outlines.size(); ++i) {
    SCOPED_TRACE(i);
    expectCoveredHoweverItIsWritten(outlines[i]);
  }
}

TEST(PolygonCut, CoversOutlinesOfManyCorners) {
  Random random(3);
  for (const int count : {9, 100, 3000}) {
    SCOPED_TRACE(count);
    std::vector<glm::dvec2> star;
    for (int i = 0; i < count; ++i) {
      const double angle = 2.0 * M_PI * i / count, radius = 0.2 + random.uniform();
      star.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    expectCovered(placed(star, {0, 0, 1}, {1, 0, 0}, {3, -3, 7}), {0, 1, 0}, areaOf(star));
  }
}

TEST(PolygonCut, CoversStarsAndSpirals) {
  Random random(7);
  for (int round = 0; round < 300; ++round) {
    std::vector<glm::dvec2> star;
    const int count = 3 + static_cast<int>(40.0 * random.uniform());
    for (int i = 0; i < count; ++i) {
      const double angle = 6.283185307 * (i + 0.3 * random.uniform()) / count, radius = 0.05 + random.uniform();
      star.push_back(radius * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
    if (areaOf(star) > 0.01) expectCovered(placed(star, {0, 1, 0}, {0, 0, 1}, {1e5, 0, 0}), {1, 0, 0}, areaOf(star));
  }
  std::vector<glm::dvec2> spiral;
  for (int i = 0; i < 1024; ++i) {
    const double turn = 0.1 * (i < 512 ? i : 1023 - i), radius = (i < 512 ? 1.0 : 0.9) + 0.5 * turn;
    spiral.push_back(radius * glm::dvec2(std::cos(turn), std::sin(turn)));
  }
  expectCovered(placed(spiral, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}), {0, 0, 1}, areaOf(spiral));
}

TEST(PolygonCut, CutsDiscsOfThousandsOfCorners) {
  std::vector<glm::dvec2> disc;
  for (int i = 0; i < 8192; ++i)
    disc.emplace_back(std::cos(6.283185307179586 * i / 8192), std::sin(6.283185307179586 * i / 8192));
  expectCovered(placed(disc, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}), {0, 0, 1}, areaOf(disc));
}

TEST(PolygonCut, TakesTheShorterDiagonalOfAQuad) {
  const PolygonCut cut = cutPolygon({{0, 0, 0}, {1, 0, 0}, {3, 2, 0}, {0, 1, 0}});
  ASSERT_EQ(cut.triangles.size(), 2u);
  for (const glm::uvec3& t : cut.triangles) EXPECT_TRUE(t.x != 0 || t.y != 2) << "1 to 3 is the shorter one";
  for (const glm::uvec3& t : cut.triangles) EXPECT_EQ((t.x == 1) + (t.y == 1) + (t.z == 1), 1);
}

TEST(PolygonCut, SaysWhereAnOutlineCrossesItself) {
  EXPECT_FALSE(cutPolygon({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).holds_area) << "a bow";
  EXPECT_FALSE(cutPolygon({{0, 0, 0}, {4, 0, 0}, {1, 2, 0}, {3, 2, 0}}).holds_area);
  EXPECT_TRUE(cutPolygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).triangles.empty()) << "all on a line";
  Random random(3);
  std::vector<glm::dvec3> tangle;
  for (int i = 0; i < 1024; ++i) tangle.emplace_back(random.uniform(), random.uniform(), random.uniform());
  EXPECT_FALSE(cutPolygon(tangle).holds_area);
}

}  // namespace
}  // namespace nlg
