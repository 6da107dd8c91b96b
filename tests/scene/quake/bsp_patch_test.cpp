#include "scene/quake/bsp_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace nlg {
namespace {

using Points = std::vector<glm::dvec3>;

// How often each directed edge is used, by the positions' bits.
using Edges = std::map<std::pair<std::vector<double>, std::vector<double>>, int>;

std::vector<double> key(const glm::dvec3& p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

void countEdges(const PatchMesh& mesh, Edges& edges) {
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[{key(mesh.positions[t[k]]), key(mesh.positions[t[(k + 1) % 3]])}];
  }
}

double area(const PatchMesh& mesh) {
  double sum = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    sum += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
  }
  return sum;
}

Points randomControl(std::mt19937& random, uint32_t width, uint32_t height, double bend) {
  std::uniform_real_distribution<double> noise(-bend, bend);
  Points control;
  for (uint32_t row = 0; row < height; ++row) {
    for (uint32_t column = 0; column < width; ++column) {
      control.emplace_back(100.0 * column + noise(random), 100.0 * row + noise(random), noise(random));
    }
  }
  return control;
}

TEST(BspPatch, AFlatPatchIsTwoTriangles) {
  Points control;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) control.emplace_back(10 * column, 10 * row, 5);
  }
  const PatchMesh mesh = tessellatePatch(control, 3, 3, 1.0);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_DOUBLE_EQ(area(mesh), 400.0);
  // columns to the right, rows upward: counter-clockwise
  const glm::uvec3 t = mesh.triangles[0];
  EXPECT_GT(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]).z, 0.0);
}

TEST(BspPatch, StaysWithinTheToleranceOfTheSurface) {
  // a parabolic cylinder: control points (0, 0), (100, 100), (200, 0) give z = x (200 - x) / 200
  Points control;
  for (const double y : {0.0, 50.0, 100.0}) {
    control.insert(control.end(), {{0, y, 0}, {100, y, 100}, {200, y, 0}});
  }
  size_t last_count = 0;
  for (const double tolerance : {20.0, 4.0, 1.0, 0.2}) {
    const PatchMesh mesh = tessellatePatch(control, 3, 3, tolerance);
    for (const glm::dvec3& p : mesh.positions) EXPECT_NEAR(p.z, p.x * (200 - p.x) / 200, 1e-9);
    for (const glm::uvec3& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        const glm::dvec3 middle = 0.5 * (mesh.positions[t[k]] + mesh.positions[t[(k + 1) % 3]]);
        EXPECT_NEAR(middle.z, middle.x * (200 - middle.x) / 200, tolerance);
      }
    }
    EXPECT_GT(mesh.triangles.size(), last_count) << "a finer tolerance takes more triangles";
    last_count = mesh.triangles.size();
  }
}

TEST(BspPatch, InnerEdgesAreSharedByExactlyTwoTriangles) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    const uint32_t width = 3 + 2 * (random() % 3), height = 3 + 2 * (random() % 3);
    const PatchMesh mesh = tessellatePatch(randomControl(random, width, height, round * 0.4), width, height, 1.5);
    EXPECT_LE(mesh.triangles.size(), maxPatchTriangles(width, height));
    Edges edges;
    countEdges(mesh, edges);
    // what has no partner runs once around the outside: as many edges in as out of every point
    std::map<std::vector<double>, int> balance;
    for (const auto& [edge, count] : edges) {
      ASSERT_EQ(count, 1) << "an edge is used twice in one direction, round " << round;
      if (edges.count({edge.second, edge.first}) > 0) continue;
      ++balance[edge.first];
      --balance[edge.second];
    }
    for (const auto& [point, difference] : balance) EXPECT_EQ(difference, 0) << "round " << round;
  }
}

// The heart of it: two patches that agree along an edge, whatever else they are and however they are turned.
TEST(BspPatch, NeighboursThatAgreeAlongAnEdgeLeaveNoCrack) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    const uint32_t width = 3 + 2 * (random() % 3), height = 3 + 2 * (random() % 2);
    const Points first = randomControl(random, width, height, 30.0);
    Points second = randomControl(random, width, height, 90.0);
    // the last row of the first is the first row of the second; then the second is turned by half a turn, so that it runs
    // backward
    std::copy(first.end() - width, first.end(), second.begin());
    if (round % 2 == 1) std::reverse(second.begin(), second.end());
    Edges edges;
    countEdges(tessellatePatch(first, width, height, 0.7), edges);
    Edges of_second;
    countEdges(tessellatePatch(second, width, height, 0.7), of_second);
    size_t shared_count = 0;
    for (const auto& [edge, count] : of_second) shared_count += edges.count({edge.second, edge.first});
    // the seam's length in edges, from a patch that is the seam's curve drawn out straight
    Points drawn_out;
    for (int row = 0; row < 3; ++row) {
      for (auto p = first.end() - width; p != first.end(); ++p) drawn_out.push_back(*p + glm::dvec3(0, 0, 100 * row));
    }
    const size_t seam_count = tessellatePatch(drawn_out, width, 3, 0.7).positions.size() / 2 - 1;
    EXPECT_EQ(shared_count, seam_count) << "round " << round;
  }
}

}  // namespace
}  // namespace nlg
