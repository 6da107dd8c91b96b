#include "scene/solid/closed_shells.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scene/solid/double_sided.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/scene/scene_triangles.h"

namespace nlg {
namespace {

using Quads = std::vector<std::array<glm::vec3, 4>>;

// Objects of faces that share no vertices, as exporters write them; all of one double-sided material unless told otherwise.
class SceneOfObjects {
 public:
  SceneOfObjects() {
    scene_.cavity_m = 0.5;
    scene_.materials.resize(2);
    scene_.materials[0].double_sided = true;
    scene_.materials[1].double_sided = true;
    scene_.materials[1].transmissive = Transmissive::dense;
  }

  SceneOfObjects& object(const std::string& name) {
    scene_.objects.push_back({name, static_cast<uint32_t>(scene_.triangles.size()), 0, true});
    return *this;
  }
  SceneOfObjects& triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, uint32_t material = 0) {
    const auto first = static_cast<uint32_t>(scene_.positions.size());
    scene_.positions.insert(scene_.positions.end(), {a, b, c});
    scene_.triangles.push_back({first, first + 1, first + 2});
    scene_.triangle_material.push_back(material);
    ++scene_.objects.back().triangle_count;
    return *this;
  }
  SceneOfObjects& quads(const Quads& quads) {
    for (const auto& [a, b, c, d] : quads) triangle(a, b, c).triangle(a, c, d);
    return *this;
  }
  SceneOfObjects& lamp(const glm::vec3& at) {
    Lamp lamp;
    lamp.position = at;
    scene_.light.lamps.push_back(lamp);
    return *this;
  }
  SceneOfObjects& camera(const glm::vec3& at) {
    scene_.viewpoints.push_back({"camera", at});
    return *this;
  }
  Scene scene_;
};

Quads inverted(Quads quads) {
  for (auto& [a, b, c, d] : quads) std::swap(b, d);
  return quads;
}

Quads without(Quads quads, size_t side) {
  quads.erase(quads.begin() + static_cast<std::ptrdiff_t>(side));
  return quads;
}

Quads square(float y) { return {{glm::vec3(0, y, 0), glm::vec3(0, y, 1), glm::vec3(1, y, 1), glm::vec3(1, y, 0)}}; }

// Outer and inner faces of a house of 4 x 3 x 4 m, joined through a window in its far wall: one manifold, as solidified ones are.
Quads houseWithWindow() {
  Quads house = without(boxSides({0, 0, 0}, {4, 3, 4}), 5);
  for (const auto& quad : without(inverted(boxSides({0.2f, 0.2f, 0.2f}, {3.8f, 2.8f, 3.8f})), 5)) house.push_back(quad);
  // rings around the opening: outside at z = 4, its reveal, inside at z = 3.8
  const auto corners = [](float low, float high, float up, float z) {
    return std::array{glm::vec3(low, high, z), glm::vec3(4 - low, high, z), glm::vec3(4 - low, up, z), glm::vec3(low, up, z)};
  };
  const std::array rings{corners(0, 0, 3, 4), corners(1, 1, 2, 4), corners(1, 1, 2, 3.8f), corners(0.2f, 0.2f, 2.8f, 3.8f)};
  for (size_t ring = 0; ring < 3; ++ring) {
    for (int k = 0; k < 4; ++k)
      house.push_back({rings[ring][k], rings[ring][(k + 1) % 4], rings[ring + 1][(k + 1) % 4], rings[ring + 1][k]});
  }
  return house;
}

// Something outside: a sheet of ground, far below.
SceneOfObjects onGround() {
  const float y = -20;
  return SceneOfObjects().object("ground").quads(
      {{glm::vec3(-20, y, -20), glm::vec3(-20, y, 20), glm::vec3(20, y, 20), glm::vec3(20, y, -20)}});
}

// Names of objects that have been made solid, wholly; "name?" for one of which only a part has.
std::vector<std::string> solidsOf(SceneOfObjects objects, DoubleSidedFaces* faces = nullptr) {
  Scene& scene = objects.scene_;
  const DoubleSidedFaces result = giveSolidsOneSide(scene);
  if (faces != nullptr) *faces = result;
  std::vector<std::string> solids;
  for (const SceneObject& object : scene.objects) {
    uint32_t count = 0;
    for (uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i)
      count += !scene.materials[scene.triangle_material[i]].double_sided;
    if (count > 0) solids.push_back(object.name + (count < object.triangle_count ? "?" : ""));
  }
  return solids;
}

using Names = std::vector<std::string>;

Shell shellOf(const Quads& quads) {
  const Scene scene = SceneOfObjects().object("").quads(quads).scene_;
  ShellFinder finder(weldedVertices(scene.positions));
  const Components components = finder.components(scene.triangles);
  EXPECT_EQ(components.count, 1u);
  return finder.measure(scene.positions, scene.triangles, components)[0];
}

TEST(ClosedShells, MeasuresABoxOfSplitVerticesAndTheHoleOfAMissingSide) {
  const Shell shell = shellOf(boxSides({1, 2, 3}, {2, 4, 6}));
  EXPECT_EQ(shell.open_length_m, 0.0);
  EXPECT_EQ(shell.hole_area_m2, 0.0);
  EXPECT_NEAR(shell.volume_m3, 6.0, 1e-12);
  EXPECT_NEAR(shell.area_m2, 22.0, 1e-12);
  EXPECT_NEAR(shellOf(inverted(boxSides({1, 2, 3}, {2, 4, 6}))).volume_m3, -6.0, 1e-12);
  const Shell open = shellOf(without(boxSides({1, 2, 3}, {2, 4, 6}), 0));
  EXPECT_NEAR(open.hole_area_m2, 6.0, 1e-12);
  EXPECT_NEAR(open.open_length_m, 10.0, 1e-12);
}

TEST(ClosedShells, AVertexOnANeighboursEdgeLeavesAnOpenEdgeAndNoHole) {
  Quads sides = without(boxSides({0, 0, 0}, {1, 1, 1}), 5);
  sides.push_back({glm::vec3(0, 0, 1), glm::vec3(0.5f, 0, 1), glm::vec3(0.5f, 1, 1), glm::vec3(0, 1, 1)});
  sides.push_back({glm::vec3(0.5f, 0, 1), glm::vec3(1, 0, 1), glm::vec3(1, 1, 1), glm::vec3(0.5f, 1, 1)});
  const Shell shell = shellOf(sides);
  EXPECT_NEAR(shell.open_length_m, 4.0, 1e-12);
  EXPECT_NEAR(shell.hole_area_m2, 0.0, 1e-12);
  EXPECT_EQ(solidsOf(onGround().object("box").quads(sides)), Names{"box"});
}

TEST(ClosedShells, KeepsSetsOfTrianglesApart) {
  const Scene scene =
      SceneOfObjects().object("").quads(boxSides({0, 0, 0}, {1, 1, 1})).quads(boxSides({1, 0, 0}, {2, 1, 1})).scene_;
  ShellFinder finder(weldedVertices(scene.positions));
  const std::span<const glm::uvec3> triangles = scene.triangles;
  EXPECT_EQ(finder.components(triangles).count, 1u);
  EXPECT_EQ(finder.components(triangles.first(12)).count, 1u);
  EXPECT_EQ(finder.components(triangles.first(4)).count, 2u) << "two opposite sides";
}

TEST(DoubleSided, AClosedPartWoundOutwardIsSolid) {
  DoubleSidedFaces faces;
  EXPECT_EQ(solidsOf(onGround().object("box").quads(boxSides({0, 0, 0}, {1, 1, 1})), &faces), Names{"box"});
  EXPECT_EQ(faces.face_count, 14u);
  EXPECT_EQ(faces.solid_count, 12u);
  EXPECT_EQ(faces.note(), "12 of its 14 double-sided faces bound solid, 2 are sheets");
}

TEST(DoubleSided, OpenAndFlatPartsAreSheets) {
  Quads two_faced = square(0);
  two_faced.push_back(inverted(square(0))[0]);
  for (const Quads& quads : {without(boxSides({0, 0, 0}, {1, 1, 1}), 2), square(0), two_faced})
    EXPECT_EQ(solidsOf(onGround().object("sheet").quads(quads)), Names{}) << quads.size();
}

TEST(DoubleSided, PartsAreJudgedByThemselvesAndAPlainBoxWoundInwardIsNoSolid) {
  EXPECT_EQ(solidsOf(SceneOfObjects().object("flipped").quads(inverted(boxSides({0, 0, 0}, {1, 1, 1})))), Names{});
  EXPECT_EQ(solidsOf(SceneOfObjects().object("shelf").quads(boxSides({0, 0, 0}, {1, 1, 1})).quads(square(5))), Names{"shelf?"});
}

TEST(DoubleSided, BoxesThatTouchAreSolid) {
  const Quads left = boxSides({0, 0, 0}, {1, 1, 1}), right = boxSides({1, 0, 0}, {2, 1, 1});
  EXPECT_EQ(solidsOf(onGround().object("joined").quads(left).quads(right)), Names{"joined"});
  EXPECT_EQ(solidsOf(onGround().object("left").quads(left).object("right").quads(right)), (Names{"left", "right"}));
}

TEST(DoubleSided, TransmissiveSurfacesCloseNothing) {
  SceneOfObjects objects = onGround();
  objects.object("lantern").quads(without(boxSides({0, 0, 0}, {1, 1, 1}), 5));
  objects.triangle({0, 0, 1}, {1, 0, 1}, {1, 1, 1}, 1).triangle({0, 0, 1}, {1, 1, 1}, {0, 1, 1}, 1);
  DoubleSidedFaces faces;
  EXPECT_EQ(solidsOf(objects, &faces), Names{});
  EXPECT_EQ(faces.face_count, 12u);
}

const Quads kRoom = boxSides({0, 0, 0}, {5, 3, 4});

TEST(DoubleSided, ARoomWoundOutwardIsHollowByWhateverLiesInIt) {
  const auto room = [] { return onGround().object("room").quads(kRoom); };
  EXPECT_EQ(solidsOf(room()), Names{"room"});
  EXPECT_EQ(solidsOf(room().lamp({2, 2, 2})), Names{});
  EXPECT_EQ(solidsOf(room().camera({2, 2, 2})), Names{});
  EXPECT_EQ(solidsOf(room().lamp({2, 3.5f, 2}).camera({-1, 1, 1})), Names{"room"}) << "above the roof, before the wall";
  EXPECT_EQ(solidsOf(room().object("cabin").quads(boxSides({1, 0, 1}, {3, 2, 3})).lamp({2, 1, 2})), Names{})
      << "one in the other";
  DoubleSidedFaces faces;
  // it stands on the floor, a centimetre deep
  EXPECT_EQ(solidsOf(room().object("chest").quads(boxSides({1, -0.01f, 1}, {2, 1, 2})), &faces), Names{"chest"});
  EXPECT_EQ(faces.hollow, Names{"room"});
  EXPECT_EQ(faces.note(),
            "12 of its 26 double-sided faces bound solid, 14 are sheets; hollow, since it is wide and something lies in it, and "
            "walls with a "
            "thickness leak less than its sheets: "
            "room");
}

TEST(DoubleSided, ARoomWoundOutwardAroundAllElseIsTheOneWoundInward) {
  DoubleSidedFaces faces;
  EXPECT_EQ(solidsOf(SceneOfObjects().object("room").quads(kRoom).lamp({2, 2, 2}), &faces), Names{"room"});
  EXPECT_EQ(faces.note(),
            "all of its 12 double-sided faces bound solid; a room seen from within, so that its faces were turned "
            "inward: room");
  Scene outward = SceneOfObjects().object("room").quads(kRoom).lamp({2, 2, 2}).scene_;
  giveSolidsOneSide(outward);
  EXPECT_NEAR(volumeOf(outward, outward.objects[0]), -5.0 * 3.0 * 4.0, 1e-4);
}

TEST(DoubleSided, ABoxThatIsAllThereIsIsARoom) {
  DoubleSidedFaces faces;
  EXPECT_EQ(solidsOf(SceneOfObjects().object("room").quads(kRoom), &faces), Names{"room"});
  EXPECT_EQ(faces.turned, Names{"room"});
  solidsOf(SceneOfObjects().object("cube").quads(kRoom).lamp({9, 2, 2}), &faces);
  EXPECT_EQ(faces.turned, Names{}) << "a lamp beside it";
  EXPECT_EQ(solidsOf(SceneOfObjects().object("room").quads(kRoom).object("chest").quads(boxSides({5, 0, 0}, {9, 1, 1}))),
            (Names{"room", "chest"}));
}

TEST(DoubleSided, ShellsWithHolesAreSolidWhereTheyAreNarrowOrTheirRoomsInUse) {
  // the far wall with a square hole, in four parts
  const auto holed = [](Quads box, float z) {
    Quads quads = without(std::move(box), 5);
    const glm::vec3 a(1, 1, z), b(1.7f, 1, z), c(1.7f, 1.7f, z), d(1, 1.7f, z), A(0, 0, z), B(5, 0, z), C(5, 3, z), D(0, 3, z);
    for (const auto& quad : Quads{{A, B, b, a}, {B, C, c, b}, {C, D, d, c}, {D, A, a, d}}) quads.push_back(quad);
    return quads;
  };
  const Shell shell = shellOf(holed(kRoom, 4));
  EXPECT_NEAR(shell.hole_area_m2, 0.49, 1e-6);
  EXPECT_EQ(solidsOf(onGround().object("room").quads(holed(kRoom, 4))), Names{}) << "a bare room with a window";
  EXPECT_EQ(solidsOf(onGround().object("room").quads(holed(kRoom, 4)).lamp({2, 2, 2})), Names{});
  EXPECT_EQ(solidsOf(onGround().object("room").quads(holed(kRoom, 4)).camera({2, 5, 2})), Names{}) << "above";

  // a face of the house that nobody sees, left out in part
  Quads small = houseWithWindow();
  const std::array rim = small[0];
  const glm::vec3 middle = 0.25f * (rim[0] + rim[1] + rim[2] + rim[3]);
  small.erase(small.begin());
  for (int k = 0; k < 4; ++k) {
    const glm::vec3 &p = rim[k], &q = rim[(k + 1) % 4];
    small.push_back({p, q, middle + 0.4f * (q - middle), middle + 0.4f * (p - middle)});
  }
  EXPECT_NEAR(shellOf(small).hole_area_m2, 0.16 * 12, 1e-5);
  EXPECT_EQ(solidsOf(onGround().object("house").quads(small)), Names{"house"}) << "a house that nobody lives in";
  EXPECT_EQ(solidsOf(onGround().object("house").quads(small).lamp({2.1f, 1.5f, 2.2f})), Names{"house"});
  EXPECT_EQ(solidsOf(onGround().object("house").quads(small).object("chest").quads(boxSides({1, 0.2f, 1}, {2, 1, 2}))),
            (Names{"house", "chest"}));
}

TEST(DoubleSided, WhatIsSunkIntoSolidPartlyMakesItNotHollow) {
  const auto slab = [] { return onGround().object("slab").quads(boxSides({0, -1, 0}, {5, 0, 4})); };
  EXPECT_EQ(solidsOf(slab().object("chest").quads(boxSides({1, -0.1f, 1}, {2, 1, 2}))), (Names{"slab", "chest"}));
  EXPECT_EQ(solidsOf(slab().object("post").quads(boxSides({1, -0.5f, 1}, {1.1f, 1, 1.1f}))), (Names{"slab", "post"}));
  EXPECT_EQ(
      solidsOf(slab().object("tile").quads({{glm::vec3(1, 0, 1), glm::vec3(1, 0, 2), glm::vec3(2, 0, 2), glm::vec3(2, 0, 1)}})),
      Names{"slab"})
      << "flush";
}

TEST(DoubleSided, AHouseOfOneManifoldIsSolidWithItsRoomInUse) {
  SceneOfObjects objects;
  objects.object("house").quads(houseWithWindow()).object("chest").quads(boxSides({1, 0.2f, 1}, {2, 1, 2}));
  objects.lamp({2, 2.5f, 2}).camera({2, 1.6f, 1});
  EXPECT_EQ(solidsOf(objects), (Names{"house", "chest"}));
  objects.lamp({0.1f, 1.5f, 2});
  EXPECT_EQ(solidsOf(objects), (Names{"house", "chest"})) << "a lamp in the wall";
  objects.scene_.cavity_m = 0.15;
  EXPECT_EQ(solidsOf(objects), Names{"chest"}) << "a ball as small fits into the wall";
}

TEST(DoubleSided, OuterAndInnerShellAreWallsWithTheRoomInUse) {
  const Quads outer = boxSides({0, 0, 0}, {5, 3, 4}), inner = inverted(boxSides({0.2f, 0.2f, 0.2f}, {4.8f, 2.8f, 3.8f}));
  const auto house = [&] { return SceneOfObjects().object("house").quads(outer).quads(inner); };
  const auto furnished = [&] {
    return house().object("chest").quads(boxSides({1, 0.2f, 1}, {2, 1, 2})).lamp({2, 2.5f, 2}).camera({2, 1.6f, 1});
  };
  EXPECT_EQ(solidsOf(house()), Names{"house"});
  EXPECT_EQ(solidsOf(furnished()), (Names{"house", "chest"}));
  // a sky all around, whichever way it looks
  const Quads sky = boxSides({-50, -50, -50}, {50, 50, 50});
  EXPECT_EQ(solidsOf(furnished().object("sky").quads(sky)), (Names{"house", "chest", "sky"}));
  EXPECT_EQ(solidsOf(furnished().object("sky").quads(inverted(sky))), (Names{"house", "chest", "sky"}));
}

TEST(DoubleSided, ARoomWoundInwardIsOneSidedWhenAllElseLiesInIt) {
  const auto room = [] { return SceneOfObjects().object("room").quads(inverted(kRoom)); };
  EXPECT_EQ(solidsOf(room()), Names{}) << "a box with flipped faces";
  EXPECT_EQ(solidsOf(room().lamp({2, 2, 2})), Names{"room"});
  EXPECT_EQ(solidsOf(room().object("chest").quads(boxSides({1, -0.01f, 1}, {2, 1, 2}))), (Names{"room", "chest"}));
  EXPECT_EQ(solidsOf(room().lamp({2, 2, 2}).camera({2, 2, 9})), Names{}) << "a camera outside";
  EXPECT_EQ(solidsOf(room().lamp({2, 2, 2}).object("other").quads(inverted(boxSides({6, 0, 0}, {9, 3, 4}))).lamp({7, 2, 2})),
            (Names{"room", "other"}));
}

TEST(DoubleSided, ShadesWoundInwardStaySheetsInRooms) {
  SceneOfObjects objects;
  objects.object("room").quads(inverted(kRoom)).object("shade").quads(inverted(boxSides({1, 1, 1}, {1.5f, 1.5f, 1.5f})));
  objects.lamp({1.2f, 1.2f, 1.2f});
  EXPECT_EQ(solidsOf(objects), Names{"room"});
  SceneOfObjects outward = onGround();
  outward.object("room").quads(kRoom).object("shade").quads(inverted(boxSides({1, 1, 1}, {1.5f, 1.5f, 1.5f})));
  outward.lamp({1.2f, 1.2f, 1.2f}).lamp({3, 2, 3});
  EXPECT_EQ(solidsOf(outward), Names{});
}

TEST(DoubleSided, AWallIsSolidWhateverIsSunkIntoIt) {
  const Quads wall = boxSides({0, 0, 0}, {6, 3, 0.2f});
  const auto walled = [&] { return onGround().object("wall").quads(wall); };
  const Quads pipe = boxSides({1, 0.2f, 0.05f}, {1.1f, 2.9f, 0.15f}), picture = boxSides({3, 1, 0.19f}, {4, 2, 0.195f});
  EXPECT_EQ(solidsOf(walled().object("pipe").quads(pipe)), (Names{"wall", "pipe"}));
  EXPECT_EQ(solidsOf(walled().object("picture").quads(picture)), (Names{"wall", "picture"}));
  EXPECT_EQ(solidsOf(walled().lamp({2, 2, 0.1f})), Names{"wall"});
  // a modeller's wall without its underside: a fiftieth of its area
  const Quads bottomless = without(wall, 2);
  EXPECT_EQ(solidsOf(onGround().object("wall").quads(bottomless)), Names{"wall"});
  EXPECT_EQ(solidsOf(onGround().object("wall").quads(bottomless).object("pipe").quads(pipe)), (Names{"wall", "pipe"}));
  // between outer and inner surface of a house
  const Quads outer = boxSides({0, 0, 0}, {5, 3, 4}), inner = inverted(boxSides({0.2f, 0.2f, 0.2f}, {4.8f, 2.8f, 3.8f}));
  EXPECT_EQ(solidsOf(onGround().object("house").quads(outer).quads(inner).object("pipe").quads(pipe).lamp({2, 2, 2})),
            (Names{"house", "pipe"}));
}

TEST(DoubleSided, ACupboardIsSolidUnlessItIsWide) {
  const auto cupboard = [](float depth_m) {
    return onGround()
        .object("cupboard")
        .quads(boxSides({0, 0, 0}, {1.2f, 2, depth_m}))
        .object("shelf")
        .quads(boxSides({0.02f, 1, 0.02f}, {1.18f, 1.02f, depth_m - 0.02f}));
  };
  EXPECT_EQ(solidsOf(cupboard(0.4f)), (Names{"cupboard", "shelf"}));
  EXPECT_EQ(solidsOf(cupboard(0.49f)), (Names{"cupboard", "shelf"})) << "just too narrow for a ball of 50 cm";
  EXPECT_EQ(solidsOf(cupboard(0.54f)), Names{"shelf"}) << "just wide enough";
  SceneOfObjects narrow = cupboard(0.4f);
  narrow.scene_.cavity_m = 0.3;
  EXPECT_EQ(solidsOf(narrow), Names{"shelf"});
  narrow.scene_.cavity_m = 0.0;
  EXPECT_EQ(solidsOf(narrow), Names{"shelf"}) << "all hollows are air";
}

}  // namespace
}  // namespace nlg
