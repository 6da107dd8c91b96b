#include "validate/views/scene_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "light/air.h"
#include "tests/validate/light/lit_scenes.h"
#include "validate/views/view_truth.h"

namespace nlg {
namespace {

struct Seen {
  explicit Seen(Scene made) : scene(std::move(made)), rays(scene), transport(scene, rays) {}
  // small scenes: few places tell their rooms
  SceneViews views(SceneViewOptions options = {}) const {
    options.places_in_air = 400;
    return findViews(transport, lightExtent(scene, {}), options);
  }

  Scene scene;
  RayScene rays;
  LightTransport transport;
};

TEST(SceneViews, StandInAirInEveryRoom) {
  const Seen seen(brightAndDarkRoom());
  const SceneViews found = seen.views();
  std::set<bool> sides;
  for (const SceneView& view : found.views) {
    EXPECT_TRUE(isInAir(seen.rays, view.camera.eye_m));
    EXPECT_NEAR(view.camera.eye_m.y, kEyeHeightM, 1e-3);
    EXPECT_TRUE(view.has_roof);
    sides.insert(view.camera.eye_m.x < kWallLow);
    ASSERT_EQ(view.figure.size(), 3u) << "rooms of 3 m by 3 m have a place that a view shows whole";
    for (const Ball& ball : view.figure) {
      const auto at = view.camera.seenAt(ball.centre_m, 192.0 / 108.0);
      ASSERT_TRUE(at);
      EXPECT_TRUE(at->x > 0.0 && at->x < 1.0 && at->y > 0.0 && at->y < 1.0) << at->x << ' ' << at->y;
      EXPECT_TRUE(isInAir(seen.rays, ball.centre_m));
      EXPECT_EQ(ball.centre_m.x < kWallLow, view.camera.eye_m.x < kWallLow) << "the figure stands in the room that is looked at";
    }
  }
  EXPECT_EQ(sides.size(), 2u);
  EXPECT_EQ(found.rooms_left_out, 0u);
}

TEST(SceneViews, LookFromHeadHeightWhereverOneStandsUpright) {
  for (const float ceiling_m : {1.9f, 2.5f, 5.0f}) {
    SceneOfFaces faces;
    faces.addRoom({-3, 0, -3}, {3, ceiling_m, 3}, 0.2f);
    const SceneViews found = Seen(faces.finish()).views();
    EXPECT_FALSE(found.views.empty()) << ceiling_m;
    for (const SceneView& view : found.views) EXPECT_NEAR(view.camera.eye_m.y, kEyeHeightM, 1e-3);
  }
}

// A closet of 1 by 1 m and a room of 4 by 4 m, both 2.5 m high, on ground that is ten times as large. The room has a window of half
// a wall, so that places outside see what those inside see.
TEST(SceneViews, ShowRoomsAndClosetsBeforeOutdoorsAndStandNotBeforeTheirWindows) {
  SceneOfFaces faces;
  faces.addBox({-10, -0.5f, -10}, {10, 0, 10});
  faces.addBox({-2.2f, 2.5f, -2.2f}, {3.4f, 2.7f, 2.2f});  // the roof
  faces.addBox({-2.2f, 0, -2.2f}, {3.4f, 2.5f, -2});
  faces.addBox({-2.2f, 0, 2}, {3.4f, 2.5f, 2.2f});
  faces.addBox({2, 0, -2}, {2.2f, 2.5f, 2});
  faces.addBox({3.2f, 0, -2}, {3.4f, 2.5f, 2});
  faces.addBox({2.2f, 0, -2}, {3.2f, 2.5f, -0.5f});
  faces.addBox({2.2f, 0, 0.5f}, {3.2f, 2.5f, 2});
  faces.addBox({-2.2f, 0, -2}, {-2, 0.9f, 2});
  faces.addBox({-2.2f, 0.9f, -2}, {-2, 2.5f, -1});
  faces.addBox({-2.2f, 0.9f, 1}, {-2, 2.5f, 2});
  const Seen seen(faces.finish());
  SceneViewOptions options;
  const SceneViews found = findViews(seen.transport, lightExtent(seen.scene, {}), options);
  int roofed = 0, in_closet = 0;
  for (size_t v = 0; v < found.views.size(); ++v) {
    const glm::dvec3& eye = found.views[v].camera.eye_m;
    EXPECT_NEAR(eye.y, kEyeHeightM, 1e-3);
    const bool is_inside = eye.x > -2.2 && eye.x < 3.2 && std::abs(eye.z) < 2.0;
    EXPECT_EQ(found.views[v].has_roof, is_inside) << eye.x << ' ' << eye.z;
    EXPECT_TRUE(v == 0 || found.views[v - 1].has_roof || !found.views[v].has_roof) << "outdoors comes last";
    roofed += is_inside;
    in_closet += is_inside && eye.x > 2.2;
  }
  EXPECT_GE(in_closet, 1);
  EXPECT_GE(roofed - in_closet, 1);
  options.most_views = roofed;
  for (const SceneView& view : findViews(seen.transport, lightExtent(seen.scene, {}), options).views) EXPECT_TRUE(view.has_roof);
}

// A table of 1.6 x 1 m on legs, and a cellar that is as low as it: below the one nobody stands, in the other one crouches.
TEST(SceneViews, StandNeitherBelowTablesNorOnThemButInLowRooms) {
  SceneOfFaces faces;
  faces.addRoom({-2, 0, -2}, {2, 3, 2}, 0.2f);
  faces.addBox({-0.8f, 0.75f, -0.5f}, {0.8f, 0.8f, 0.5f});
  SceneViewOptions options;
  options.views_per_room = 8;
  for (const SceneView& view : Seen(faces.finish()).views(options).views) EXPECT_NEAR(view.camera.eye_m.y, kEyeHeightM, 1e-3);
  SceneOfFaces cellar;
  cellar.addRoom({-2, 0, -2}, {2, 0.75f, 2}, 0.2f);
  const SceneViews found = Seen(cellar.finish()).views(options);
  EXPECT_FALSE(found.views.empty());
  for (const SceneView& view : found.views) EXPECT_NEAR(view.camera.eye_m.y, 0.75 - kOverEyesM, 1e-3);
  // nor on it: a stride around any place on a table of 1 x 1 m goes beyond its edge
  SceneOfFaces with_table;
  with_table.addRoom({-2, 0, -2}, {2, 4, 2}, 0.2f);
  with_table.addBox({-0.5f, 0, -0.5f}, {0.5f, 0.8f, 0.5f});
  for (const SceneView& view : Seen(with_table.finish()).views(options).views)
    EXPECT_NEAR(view.camera.eye_m.y, kEyeHeightM, 1e-3);
}

// A wall of two boards with 60 cm of air between them: an eye would find elbow room there, and a figure does not.
TEST(SceneViews, StandInNoHollowOfAWall) {
  SceneOfFaces faces;
  faces.addRoom({-2, 0, -2}, {4, 2.5f, 2}, 0.2f);
  faces.addBox({1, 0, -2}, {1.05f, 2.5f, 2});
  faces.addBox({1.65f, 0, -2}, {1.7f, 2.5f, 2});
  SceneViewOptions options;
  options.views_per_room = 3;
  const SceneViews found = Seen(faces.finish()).views(options);
  std::set<bool> sides;
  for (const SceneView& view : found.views) {
    EXPECT_TRUE(view.camera.eye_m.x < 1.0 || view.camera.eye_m.x > 1.7) << view.camera.eye_m.x;
    sides.insert(view.camera.eye_m.x < 1.0);
  }
  EXPECT_EQ(sides.size(), 2u);
  EXPECT_EQ(found.rooms_without_floor, 1u);
}

bool isSame(const SceneViews& a, const SceneViews& b) {
  const auto isSameView = [](const SceneView& x, const SceneView& y) {
    return x.room == y.room && x.camera.eye_m == y.camera.eye_m && x.camera.forward == y.camera.forward;
  };
  return a.rooms_dark == b.rooms_dark && std::equal(a.views.begin(), a.views.end(), b.views.begin(), b.views.end(), isSameView);
}

// Kin of Sponza: a court below the sky that is surrounded by eight larger closed halls, which no light reaches.
TEST(SceneViews, LookIntoTheOpenBeforeHallsWithoutLight) {
  SceneOfFaces faces;
  for (int x = -1; x <= 1; ++x) {
    for (int z = -1; z <= 1; ++z) {
      const glm::vec3 middle(8.2f * x, 0, 8.2f * z), half(4, 0, 4);
      if (x != 0 || z != 0) faces.addRoom(middle - half, middle + half + glm::vec3(0, 3, 0), 0.1f);
    }
  }
  faces.addBox({-4, -0.2f, -4}, {4, 0, 4});
  Scene scene = faces.finish();
  scene.light.sky = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  const Seen seen(std::move(scene));
  SceneViewOptions options;
  options.most_views = 3;
  const SceneViews found = seen.views(options);
  ASSERT_FALSE(found.views.empty());
  const glm::dvec3& eye = found.views.front().camera.eye_m;
  EXPECT_TRUE(std::abs(eye.x) < 4.0 && std::abs(eye.z) < 4.0) << eye.x << ' ' << eye.z;
  EXPECT_EQ(found.rooms_dark, 8u);
  options.thread_count = 3;
  EXPECT_TRUE(isSame(found, seen.views(options)));
}

// Six closets of 2 x 2 m and a smaller room, in which the one lamp is.
TEST(SceneViews, ShowTheRoomOfTheOnlyLampFirst) {
  SceneOfFaces faces;
  for (int r = 0; r < 6; ++r) faces.addRoom({3.0f * r, 0, 0}, {3.0f * r + 2, 2.5f, 2}, 0.2f);
  faces.addRoom({0, 0, 5}, {1.8f, 2.5f, 6.8f}, 0.2f);
  Scene scene = faces.finish();
  scene.light.lamps.push_back({{0.9f, 2.2f, 5.9f}, glm::vec3(5.0f), 0.05f});
  const SceneViews found = Seen(std::move(scene)).views();
  ASSERT_GE(found.views.size(), 2u);
  EXPECT_GT(found.views[0].camera.eye_m.z, 5.0);
  EXPECT_EQ(found.rooms_dark, 6u);
}

// In an empty box edges are known: where a wall, floor or ceiling that the receiver does not lie on is within 10 cm.
TEST(ViewSurfaces, KnowEdgesAndWhatIsNear) {
  const glm::dvec3 low(-2, 0, -2), high(2, 3, 2);
  SceneOfFaces faces;
  faces.addRoom(glm::vec3(low), glm::vec3(high), 0.2f);
  const Seen seen(faces.finish());
  const SceneView view{0, cameraAlong({-1.5, 1.5, -1.5}, {1, -0.3, 1}, 1.2), {}};
  const ViewSurfaces surfaces = surfacesOf(seen.transport, view, 96, 54, 2);
  int edges = 0;
  for (size_t i = 0; i < surfaces.classes.size(); ++i) {
    const Receiver& receiver = surfaces.sights.samples[i].receiver;
    double away = INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(receiver.normal[axis]) > 0.5f) continue;
      away = std::min({away, receiver.position_m[axis] - low[axis], high[axis] - receiver.position_m[axis]});
    }
    // sixteen rays meet a wall at an angle of at most a sixteenth of a half turn
    const double seldom = std::cos(3.14159265 / 16);
    if (away < seldom * kEdgeM) {
      EXPECT_TRUE(surfaces.isOf(i, ViewClass::edge)) << away;
    } else if (away > kEdgeM) {
      EXPECT_FALSE(surfaces.isOf(i, ViewClass::edge)) << away;
    }
    EXPECT_FALSE(surfaces.isOf(i, ViewClass::shadow)) << "there is no sun";
    edges += surfaces.isOf(i, ViewClass::edge);
  }
  EXPECT_GT(edges, 50);
}

// A sun straight above a roof: what lies under it is in shadow.
TEST(ViewSurfaces, TellSunFromShadow) {
  SceneOfFaces faces;
  faces.addBox({-20, -1, -20}, {20, 0, 20});
  faces.addBox({-2, 3, -2}, {2, 3.2f, 2});
  Scene scene = faces.finish();
  scene.light.suns.emplace_back().irradiance = glm::vec3(3.0f);
  const Seen seen(scene);
  SceneView view{0, cameraAlong({-6, 2, 0}, {1, -0.3, 0}, 1.2), {}};
  view.figure = {{{-4, 1, 0}, 0.3}, {{1, 1, 1}, 0.3}};
  const ViewSurfaces surfaces = surfacesOf(seen.transport, view, 96, 54, 1);
  int sunny = 0, shadowed = 0, on_figure = 0;
  for (size_t i = 0; i < surfaces.classes.size(); ++i) {
    const Sight& sight = surfaces.sights.samples[i];
    if (sight.kind != Sight::Kind::receiver) {
      EXPECT_EQ(surfaces.classes[i], 0);
      continue;
    }
    on_figure += surfaces.isOf(i, ViewClass::figure);
    if (sight.receiver.normal.y < 0.9f) continue;
    const glm::dvec3& at = sight.receiver.position_m;
    const bool is_under = at.y < 3.0 && std::abs(at.x) < 2.0 && std::abs(at.z) < 2.0;
    EXPECT_EQ(surfaces.isOf(i, ViewClass::shadow), is_under) << at.x << ' ' << at.y << ' ' << at.z;
    ++(is_under ? shadowed : sunny);
  }
  EXPECT_GT(sunny, 100);
  EXPECT_GT(shadowed, 20);
  EXPECT_GT(on_figure, 20);
}

}  // namespace
}  // namespace nlg
