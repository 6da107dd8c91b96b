#include "datagen/visibility/probe_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "datagen/visibility/segment_kernel.h"
#include "tests/datagen/named_scenes.h"
#include "tests/runtime_eval/each_target.h"

namespace nlg {
namespace {

// A metre apart, the origin among its points.
ProbeTreeFrame metres() {
  ProbeTreeFrame frame;
  frame.first_m = {-3.0, -3.0, -3.0};
  return frame;
}
constexpr LatticePoint kOrigin = {3, 3, 3};

// The cells around the origin, by the octant of its support that each is.
LatticePoint cellLow(int octant) {
  LatticePoint low = kOrigin;
  for (int axis = 0; axis < 3; ++axis) low[axis] -= octant >> axis & 1;
  return low;
}

std::shared_ptr<const LatticeCell> cellAt(const RayScene& rays, int octant) {
  ProbeLattice lattice(metres());
  return CellSampler(rays).cellOf(cellLow(octant), 1, &lattice);
}

glm::dvec3 placeOf(int octant, size_t point) { return ProbeLattice(metres()).placeOf(cellLow(octant), 1, cellPoint(point)); }

// All triangles that touch the cube of a cell's links, looked for among all.
std::vector<LocalTriangle> trianglesAround(const RayScene& rays, int octant) {
  std::vector<uint32_t> all(rays.triangles().size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<LocalTriangle> triangles;
  const glm::dvec3 middle = ProbeLattice(metres()).placeOf(cellLow(octant), 1, {0.5f, 0.5f, 0.5f});
  collectLocalTriangles(rays.positions(), rays.triangles(), all, middle, kCellReach, &triangles);
  return triangles;
}

struct Ends {
  LocalPoint from, to;
};

Ends endsOf(size_t link) {
  const LinkPackets& packets = cellLinks().packets;
  Ends ends;
  for (int axis = 0; axis < 3; ++axis) ends.from[axis] = packets.from[axis][link], ends.to[axis] = packets.to[axis][link];
  return ends;
}

constexpr size_t kLinks = 16932;

TEST(ProbeLattice, FindsEveryLinkAsTheDefinitionDoesOnEveryTarget) {
  // segmentMeets for every pair of link and triangle; where the ends of segments touch walls exactly, too
  SceneOfFaces touching;
  const LocalPoint& point = cellPoint(500);
  touching.addQuad({point[0], -3, -3}, {point[0], 3, -3}, {point[0], 3, 3}, {point[0], -3, 3}, Sides::two);
  touching.addTriangle({0.1f, 0.2f, point[2]}, {0.9f, 0.2f, point[2]}, {0.1f, 0.9f, point[2]}, Sides::one);
  std::vector<NamedScene> all = namedScenes();
  all.push_back({"faces through support points", touching.finish()});
  for (const NamedScene& named : all) {
    const RayScene rays(named.scene);
    for (const int octant : {0, 5}) {
      const std::vector<LocalTriangle> triangles = trianglesAround(rays, octant);
      std::vector<bool> is_open(kLinks);
      for (size_t link = 0; link < kLinks; ++link) {
        const Ends ends = endsOf(link);
        is_open[link] = std::none_of(triangles.begin(), triangles.end(),
                                     [&](const LocalTriangle& t) { return segmentMeets(t, ends.from, ends.to); });
      }
      forEachTarget([&] {
        const auto cell = cellAt(rays, octant);
        for (size_t link = 0; link < kLinks; ++link)
          ASSERT_EQ(cell->isOpen(link), is_open[link]) << named.name << ", octant " << octant << ", link " << link;
      });
    }
  }
}

// The triangles with rims that reach so much farther than they do.
bool meetsAny(const std::vector<LocalTriangle>& triangles, float farther, const Ends& ends) {
  return std::any_of(triangles.begin(), triangles.end(), [&](LocalTriangle triangle) {
    for (int e = 0; e < 3; ++e) triangle.reach[e] += farther;
    return segmentMeets(triangle, ends.from, ends.to);
  });
}

TEST(ProbeLattice, FindsEveryLinkAsEmbreeDoesByBruteForce) {
  // an intersector of another make, without our hierarchy; only where a link passes a rim within kEdgeReach may it differ
  for (const NamedScene& named : namedScenes()) {
    const RayScene rays(named.scene);
    size_t blocked = 0, at_rims = 0;
    for (int octant = 0; octant < kCellCorners; ++octant) {
      const auto cell = cellAt(rays, octant);
      const std::vector<LocalTriangle> triangles = trianglesAround(rays, octant);
      const glm::dvec3 middle = ProbeLattice(metres()).placeOf(cellLow(octant), 1, {0.5f, 0.5f, 0.5f});
      for (size_t link = 0; link < kLinks; ++link) {
        const Ends ends = endsOf(link);
        const auto place = [&](const LocalPoint& at) { return glm::vec3(middle + kCellReach * glm::dvec3(at[0], at[1], at[2])); };
        blocked += !cell->isOpen(link);
        if (cell->isOpen(link) != rays.isBlocked(place(ends.from), place(ends.to))) continue;
        ASSERT_NE(meetsAny(triangles, -4 * kEdgeReach, ends), meetsAny(triangles, 4 * kEdgeReach, ends))
            << named.name << ", octant " << octant << ", link " << link;
        ++at_rims;
      }
    }
    EXPECT_GT(blocked, 0u) << named.name;
    EXPECT_LT(at_rims, blocked / 100) << named.name;
  }
}

TEST(ProbeLattice, SeesWhatEyesSeeByTheDefinition) {
  for (const NamedScene& named : namedScenes()) {
    const RayScene rays(named.scene);
    ProbeLattice lattice(metres());
    CellSampler sampler(rays);
    SupportVisibility visibility(rays);
    // in air, and in the wall that some scenes have
    for (const LatticePoint& at : {kOrigin, LatticePoint{4, 3, 3}}) {
      const auto sight = sampler.sightOf(at, 1, &lattice);
      const glm::dvec3 place = lattice.placeOf(at, 1, {});
      EXPECT_EQ(sight->vote.solid(), voteAt(rays, place).solid()) << named.name;
      visibility.beginProbe(place, 1.0f);
      EXPECT_EQ(sight->triangle_count, visibility.triangles().size()) << named.name;
      for (int octant = 0; octant < kCellCorners; ++octant) {
        for (size_t i = 0; i < kOctantPointCount; ++i) {
          const LocalPoint& local = supportPattern().points[static_cast<size_t>(octant) * kOctantPointCount + i];
          const bool is_seen = sight->eye && visibility.isOpen(*sight->eye, local);
          ASSERT_EQ(sight->seenIn(octant).has(cellLinks().point_of[octant][i]), is_seen) << named.name << ", octant " << octant;
        }
      }
    }
  }
}

// The rule of docs/theory/visibility.md, by brute force: unseen points that carrying open links join are one group; whoever of them is
// asked alone says what it is where rays leave no doubt.
TEST(ProbeLattice, JudgesWhatOpenLinksConnectAsOne) {
  size_t groups = 0, solid = 0;
  for (const NamedScene& named : namedScenes()) {
    const RayScene rays(named.scene);
    for (int octant = 0; octant < kCellCorners; ++octant) {
      const auto cell = cellAt(rays, octant);
      std::vector<bool> is_seen(kOctantPointCount, false);
      for (int corner = 0; corner < kCellCorners; ++corner) {
        const ProbeSight& sight = *cell->corners[corner];
        for (size_t p = 0; p < kOctantPointCount && !sight.vote.solid(); ++p)
          is_seen[p] = is_seen[p] || sight.seenIn(corner).has(p);
      }
      std::vector<size_t> parent(kOctantPointCount);
      std::iota(parent.begin(), parent.end(), size_t{0});
      const auto root = [&](size_t p) {
        while (parent[p] != p) p = parent[p] = parent[parent[p]];
        return p;
      };
      std::vector<bool> is_linked(kOctantPointCount, false);
      const auto forEachOpen = [&](const auto& visit) {
        for (size_t p = 0; p < kOctantPointCount; ++p) {
          for (int k = 0; k < kCarryingLinkCount; ++k) {
            const CellLinks::Edge& edge = cellLinks().nearest[p * kLinkCount + k];
            if (edge.away == std::array<int8_t, 3>{} && cell->isOpen(edge.link)) visit(p, edge.point);
          }
        }
      };
      forEachOpen([&](size_t a, size_t b) {
        if (!is_seen[a] && !is_seen[b]) parent[root(a)] = root(b);
      });
      forEachOpen([&](size_t a, size_t b) {
        if (is_seen[a] != is_seen[b]) is_linked[root(is_seen[a] ? b : a)] = true;
      });
      for (size_t p = 0; p < kOctantPointCount; ++p) {
        if (is_seen[p]) {
          ASSERT_TRUE(cell->valid.has(p)) << named.name << ", octant " << octant;
          continue;
        }
        ASSERT_EQ(cell->valid.has(p), cell->valid.has(root(p))) << named.name << ": one group, two verdicts, octant " << octant;
        groups += root(p) == p;
        solid += !cell->valid.has(p);
        const SolidVote own = solidVote(rays, placeOf(octant, p));
        if (own.unanimous() && !is_linked[root(p)]) {
          ASSERT_EQ(cell->valid.has(p), !own.solid()) << named.name << ", octant " << octant;
        }
      }
    }
  }
  EXPECT_GT(groups, 40u);
  EXPECT_GT(solid, 1000u);
}

TEST(ProbeLattice, ForgetsAndFindsAgain) {
  const RayScene rays(wallWithHole());
  ProbeLattice lattice(metres());
  CellSampler sampler(rays);
  const auto before = sampler.sightOf(kOrigin, 1, &lattice);
  EXPECT_EQ(sampler.sightOf(kOrigin, 1, &lattice), before);
  for (int32_t x = 0; x < 40000; ++x) sampler.sightOf({1000 + x, 0, 0}, 1, &lattice);
  const auto after = sampler.sightOf(kOrigin, 1, &lattice);
  EXPECT_NE(after, before) << "memory is bounded";
  EXPECT_EQ(after->eye, before->eye);
  EXPECT_EQ(after->seen, before->seen);
}

}  // namespace
}  // namespace nlg
