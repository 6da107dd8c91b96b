#include "datagen/visibility/support_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "runtime_eval/numbers/random.h"
#include "scene/scene_source.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/runtime_eval/each_target.h"

namespace nlg {
namespace {

const LinkTable& table() {
  static const LinkTable links = makeLinkTable(testPoints(512));
  return links;
}

struct NamedScene {
  const char* name;
  Scene scene;
};

std::vector<NamedScene> scenes() {
  SceneOfFaces room, crate;
  room.addRoom({-0.4f, -0.5f, -0.6f}, {0.7f, 0.45f, 0.55f}, 0.2f);
  crate.addBox({-0.3f, -0.9f, 0.25f}, {0.35f, -0.2f, 0.8f});
  return {{"infinite wall", infiniteWall()},
          {"half wall", halfWall()},
          {"wall with a hole", wallWithHole()},
          {"thin wall", thinWall(Sides::one)},
          {"thin double-sided wall", thinWall(Sides::two)},
          {"slivers", slivers()},
          {"room", room.finish()},
          {"crate", crate.finish()},
          {"terrain", terrainSheet(-0.3f, Sides::one)},
          {"boxes that cross", crossingBoxes()},
          {"crate with a fin", crateWithFin()}};
}

glm::vec3 pointAt(const glm::vec3& position_m, float spacing_m, uint32_t point) {
  const LocalPoint& local = table().points[point];
  return position_m + spacing_m * glm::vec3(local[0], local[1], local[2]);
}

// Visibility of a probe at `position_m`, with what it sees and what is valid.
SupportVisibility judged(const RayScene& scene, const glm::vec3& position_m = glm::vec3(0), float spacing_m = 1.0f) {
  SupportVisibility visibility(scene, table());
  visibility.beginProbe(position_m, spacing_m);
  visibility.traceProbeRays();
  visibility.testLinks();
  visibility.findValidity();
  return visibility;
}

// The triangles with rims that reach so much farther than they do.
bool meetsAny(const std::vector<LocalTriangle>& triangles, float farther, const LocalPoint& from, const LocalPoint& to) {
  return std::any_of(triangles.begin(), triangles.end(), [&](LocalTriangle triangle) {
    for (int e = 0; e < 3; ++e) triangle.reach[e] += farther;
    return segmentMeets(triangle, from, to);
  });
}

TEST(SupportVisibility, FindsEveryLinkAsEmbreeDoesByBruteForce) {
  // an intersector of another make, without our hierarchy; only where a link passes a rim within kEdgeReach may it differ
  for (const NamedScene& named : scenes()) {
    const RayScene scene(named.scene);
    const SupportVisibility visibility = judged(scene);
    size_t blocked = 0, at_rims = 0;
    for (uint32_t l = 0; l < table().links.size(); ++l) {
      const LinkTable::Link& link = table().links[l];
      const bool open = !scene.isBlocked(pointAt(glm::vec3(0), 1, link.a), pointAt(glm::vec3(0), 1, link.b));
      blocked += !visibility.linkOpen(l);
      if (visibility.linkOpen(l) == open) continue;
      const LocalPoint &a = table().points[link.a], &b = table().points[link.b];
      ASSERT_NE(meetsAny(visibility.triangles(), -2 * kEdgeReach, a, b), meetsAny(visibility.triangles(), 2 * kEdgeReach, a, b))
          << named.name << ", link " << link.a << " to " << link.b;
      ++at_rims;
    }
    EXPECT_GT(blocked, 0u) << named.name;
    EXPECT_LT(at_rims, blocked / 100) << named.name;
    EXPECT_LT(visibility.packetTestCount(), table().link_packets.tree.packetCount() * visibility.triangles().size())
        << named.name << ": nothing was left out";
  }
}

TEST(SupportVisibility, FindsEveryLinkAsTheDefinitionDoesOnEveryTarget) {
  // segmentMeets for every pair of link and triangle; where the ends of segments touch walls exactly, too
  SceneOfFaces touching;
  const LocalPoint& point = table().points[table().links[5000].a];
  touching.addQuad({point[0], -3, -3}, {point[0], 3, -3}, {point[0], 3, 3}, {point[0], -3, 3}, Sides::two);
  touching.addTriangle({0.1f, 0.2f, point[2]}, {0.9f, 0.2f, point[2]}, {0.1f, 0.9f, point[2]}, Sides::one);
  std::vector<NamedScene> all = scenes();
  all.push_back({"faces through support points", touching.finish()});
  for (const NamedScene& named : all) {
    const RayScene scene(named.scene);
    forEachTarget([&] {
      const SupportVisibility visibility = judged(scene);
      const std::vector<LocalTriangle>& triangles = visibility.triangles();
      const auto met = [&](const LocalPoint& from, const LocalPoint& to) {
        return std::any_of(triangles.begin(), triangles.end(), [&](const LocalTriangle& t) { return segmentMeets(t, from, to); });
      };
      for (uint32_t l = 0; l < table().links.size(); ++l) {
        const LinkTable::Link& link = table().links[l];
        ASSERT_EQ(visibility.linkOpen(l), !met(table().points[link.a], table().points[link.b])) << named.name << ", link " << l;
      }
      for (uint32_t p = 0; p < table().points.size(); ++p) {
        ASSERT_EQ(visibility.seen(p), !met({0, 0, 0}, table().points[p])) << named.name << ", point " << p;
      }
    });
  }
}

TEST(SupportVisibility, FindsWhatAnyEyeSeesAsTheDefinitionDoesOnEveryTarget) {
  // eyes anywhere in the support; one lies in the plane of a wall, one is a support point, one is all but on a face
  const std::vector<LocalPoint> eyes = {{0.55f, -0.4f, 0.3f},   {-0.93f, 0.11f, -0.97f},  {0.31f, 0.2f, -0.6f},
                                        table().points[4321],   {0.3100001f, 0.9f, 0.1f}, {0.2f, -0.13f, 0.0f},
                                        {-0.01f, 0.02f, 0.015f}};
  for (const NamedScene& named : scenes()) {
    const RayScene scene(named.scene);
    SupportVisibility visibility(scene, table());
    visibility.beginProbe(glm::dvec3(0), 1.0f);
    forEachTarget([&] {
      for (const LocalPoint& eye : eyes) {
        visibility.traceRays(eye);
        for (uint32_t p = 0; p < table().points.size(); ++p)
          ASSERT_EQ(visibility.seen(p), visibility.isOpen(eye, table().points[p]))
              << named.name << ", eye " << eye[0] << ' ' << eye[1] << ' ' << eye[2] << ", point " << p;
      }
    });
  }
}

TEST(SupportVisibility, CarriesValidityToWhatOpenLinksConnect) {
  // union of the support points over all open links that carry, by brute force
  std::vector<bool> carries(table().links.size(), false);
  for (size_t entry = 0; entry < table().nearest.size(); ++entry) {
    if (entry % kLinkCount < kCarryingLinkCount) carries[table().nearest[entry].link] = true;
  }
  for (const NamedScene& named : scenes()) {
    const RayScene scene(named.scene);
    SupportVisibility whole(scene, table());
    whole.beginProbe(glm::vec3(0), 1.0f);
    whole.testLinks();
    std::vector<uint32_t> parent(table().points.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t p) {
      while (parent[p] != p) p = parent[p] = parent[parent[p]];
      return p;
    };
    for (uint32_t l = 0; l < table().links.size(); ++l) {
      const LinkTable::Link& link = table().links[l];
      if (link.b < kSupportPointCount && carries[l] && whole.linkOpen(l)) parent[root(link.a)] = root(link.b);
    }
    const SupportVisibility visibility = judged(scene);
    std::vector<int> seen_group(table().points.size(), 0);
    for (uint32_t p = 0; p < kSupportPointCount; ++p) seen_group[root(p)] |= visibility.seen(p);
    for (uint32_t p = 0; p < kSupportPointCount; ++p) {
      if (seen_group[root(p)]) {
        ASSERT_TRUE(visibility.valid(p)) << named.name << ", point " << p;
      }
      ASSERT_EQ(visibility.valid(p), visibility.valid(root(p))) << named.name << ": one group, two verdicts, point " << p;
    }
    // a test point follows any support point that it has an open link to
    for (uint32_t l = 0; l < table().links.size(); ++l) {
      const LinkTable::Link& link = table().links[l];
      if (link.b < kSupportPointCount || !carries[l] || !whole.linkOpen(l) || !visibility.valid(link.a)) continue;
      ASSERT_TRUE(visibility.valid(link.b)) << named.name << ", test point " << link.b;
    }
  }
}

TEST(SupportVisibility, KnowsSolidFromAirInAClosedRoom) {
  const glm::vec3 low(-0.4f, -0.5f, -0.6f), high(0.7f, 0.45f, 0.55f);
  SceneOfFaces faces;
  faces.addRoom(low, high, 0.2f);
  const RayScene scene(faces.finish());
  const SupportVisibility visibility = judged(scene);
  EXPECT_FALSE(visibility.probeVote().solid());
  for (uint32_t p = 0; p < table().points.size(); ++p) {
    const glm::vec3 at = pointAt(glm::vec3(0), 1, p);
    const auto within = [&](const glm::vec3& a, const glm::vec3& b) {
      return glm::all(glm::greaterThan(at, a)) && glm::all(glm::lessThan(at, b));
    };
    const bool inside = within(low, high), outside = !within(low - glm::vec3(0.2f), high + glm::vec3(0.2f));
    ASSERT_EQ(visibility.valid(p), inside || outside) << "point " << at.x << ' ' << at.y << ' ' << at.z;
    ASSERT_EQ(visibility.seen(p), inside) << "point " << at.x << ' ' << at.y << ' ' << at.z;
  }
}

TEST(SupportVisibility, FindsAProbeInAWallSolid) {
  const RayScene scene(infiniteWall());
  SupportVisibility visibility(scene, table());
  const auto voteAt = [&](float x) {
    visibility.beginProbe({x, 0.013f, 0.027f}, 1.0f);
    return visibility.probeVote();
  };
  EXPECT_TRUE(voteAt(0.4f).solid());
  EXPECT_EQ(voteAt(0.4f).front, 0);
  EXPECT_FALSE(voteAt(0.2f).solid());
  EXPECT_FALSE(voteAt(0.6f).solid());
  EXPECT_FALSE(voteAt(0.4f).disputed());
}

TEST(SupportVisibility, TakesTheUndersideOfOpenTerrainForSolid) {
  const float height = -0.3f;
  const RayScene scene(terrainSheet(height, Sides::one));
  const SupportVisibility visibility = judged(scene);
  for (uint32_t p = 0; p < table().points.size(); ++p)
    ASSERT_EQ(visibility.valid(p), table().points[p][1] > height) << "point " << p;
}

TEST(SupportVisibility, TakesDoubleSidedFacesForNoEvidence) {
  const RayScene scene(terrainSheet(-0.3f, Sides::two));
  SupportVisibility visibility = judged(scene);
  for (uint32_t p = 0; p < table().points.size(); ++p) {
    ASSERT_TRUE(visibility.valid(p)) << "point " << p;
    ASSERT_EQ(visibility.seen(p), table().points[p][1] > -0.3f) << "point " << p;
  }
  visibility.beginProbe({0, -5, 0}, 1.0f);
  EXPECT_FALSE(visibility.probeVote().solid());
}

TEST(SupportVisibility, TakesAFlippedCrateForAirInside) {
  SceneOfFaces upright, flipped;
  upright.addBox({-0.3f, -0.9f, 0.25f}, {0.35f, -0.2f, 0.8f});
  flipped.addBox({-0.3f, -0.9f, 0.25f}, {0.35f, -0.2f, 0.8f}, true);
  const RayScene upright_scene(upright.finish()), flipped_scene(flipped.finish());
  const SupportVisibility as_made = judged(upright_scene), as_flipped = judged(flipped_scene);
  for (uint32_t p = 0; p < table().points.size(); ++p) {
    const LocalPoint& at = table().points[p];
    const bool inside = at[0] > -0.3f && at[0] < 0.35f && at[1] > -0.9f && at[1] < -0.2f && at[2] > 0.25f && at[2] < 0.8f;
    ASSERT_EQ(as_made.valid(p), !inside) << "point " << p;
    ASSERT_TRUE(as_flipped.valid(p)) << "point " << p;
    ASSERT_EQ(as_flipped.seen(p), as_made.seen(p)) << "point " << p;
  }
}

TEST(SupportVisibility, KnowsTheInsideOfBoxesThatCross) {
  const RayScene scene(crossingBoxes());
  const SupportVisibility visibility = judged(scene);
  for (uint32_t p = 0; p < table().points.size(); ++p) {
    const LocalPoint& at = table().points[p];
    const bool in_first = at[0] > 0.21f && at[0] < 0.47f && at[1] > -0.9f && at[1] < 0.33f && at[2] > -0.43f && at[2] < 0.31f;
    const bool in_second = at[0] > -0.37f && at[0] < 0.83f && at[1] > -0.31f && at[1] < 0.07f && at[2] > 0.11f && at[2] < 0.57f;
    ASSERT_EQ(visibility.valid(p), !in_first && !in_second) << "point " << p;
  }
}

// A yard whose walls and lid are sky, between halls that look inward: from high in the yard, rays that pass the sky meet the backs
// of the halls' walls.
TEST(SupportVisibility, TakesNoEvidenceFromBeyondTheSky) {
  SceneOfFaces faces;
  faces.addBox({-2, 0, -2}, {2, 3, 2}, true);
  const size_t yard_triangles = faces.finish().triangles.size();
  for (const glm::vec3 shift : {glm::vec3(-10, 0, 0), glm::vec3(10, 0, 0), glm::vec3(0, 0, -10), glm::vec3(0, 0, 10)})
    faces.addBox(shift + glm::vec3(-5, -3, -5), shift + glm::vec3(5, 12, 5), true);
  Scene scene = faces.finish();
  SkyFaces& sky = scene.light.sky_faces;
  sky.positions = scene.positions;
  std::vector<glm::uvec3> kept;
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    const glm::uvec3& corners = scene.triangles[t];
    const bool is_floor =
        scene.positions[corners.x].y == 0 && scene.positions[corners.y].y == 0 && scene.positions[corners.z].y == 0;
    (t < yard_triangles && !is_floor ? sky.triangles : kept).push_back(corners);
  }
  scene.triangles = kept;
  scene.triangle_material.resize(kept.size());
  scene.objects[0].triangle_count = static_cast<uint32_t>(kept.size());
  const RayScene rays(scene);
  const SupportVisibility visibility(rays, table());
  const glm::dvec3 high(0.3, 2.8, 0.1);
  EXPECT_TRUE(solidVote(rays, high).solid()) << "the halls' backs are what geometry alone shows";
  EXPECT_FALSE(visibility.voteAt(high).solid());
  EXPECT_TRUE(visibility.voteAt({0.3, -0.5, 0.1}).solid()) << "below the floor";
}

}  // namespace
}  // namespace nlg
