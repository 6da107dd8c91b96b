// Scenes to look at light with: a Cornell box, two rooms of which one is lit, rooms beside daylight.

#include "scene/procedural/procedural.h"

#include <array>

#include <fmt/ranges.h>

#include "scene/procedural/brush_grid.h"
#include "scene/procedural/level.h"
#include "tool/error.h"

namespace nlg {
namespace {

struct Family {
  const char* name;
  void (*build)(Level&);
};

constexpr uint64_t kDaylightStream = 0x6c69676874;

constexpr std::array<Family, 11> kFamilies = {{{"house", buildHouse},
                                               {"maze", buildMaze},
                                               {"colonnade", buildColonnade},
                                               {"stairs", buildStairs},
                                               {"clutter", buildClutter},
                                               {"outdoor", buildOutdoor},
                                               {"cave", buildCave},
                                               {"apartment", buildApartment},
                                               {"kitchen", buildKitchen},
                                               {"gallery", buildGallery},
                                               {"meeting", buildMeeting}}};

constexpr double kShell_m = 0.1;  // walls, floors and ceilings

uint32_t addPaint(MeshBuilder& mesh, const glm::vec3& colour) { return mesh.addMaterial({colour, glm::vec3(0.0f), false}); }

// Room inside 2 x 2 x 2 m around (0, 1, 0), open towards +z. Colours as measured at Cornell (their averages over red, green and
// blue as renderers use them), the lamp's as well.
Scene makeCornell(uint64_t) {
  MeshBuilder mesh;
  const uint32_t white = addPaint(mesh, {0.725f, 0.71f, 0.68f}), red = addPaint(mesh, {0.63f, 0.065f, 0.05f}),
                 green = addPaint(mesh, {0.14f, 0.45f, 0.091f});
  const uint32_t lamp = mesh.addMaterial({glm::vec3(0.78f), glm::vec3(17.0f, 12.0f, 4.0f), false});
  // a white block, its sides red and green, the room carved into it
  BrushGrid box;
  box.fill({-1.0 - kShell_m, -kShell_m, -1.0 - kShell_m}, {1.0 + kShell_m, 2.0 + kShell_m, 1.0}, white);
  box.fill({-1.0 - kShell_m, 0.0, -1.0}, {-1.0, 2.0, 1.0}, red);
  box.fill({1.0, 0.0, -1.0}, {1.0 + kShell_m, 2.0, 1.0}, green);
  box.carve({-1.0, 0.0, -1.0}, {1.0, 2.0, 1.0});
  box.emitObject(mesh, "box", Mobility::structure);
  mesh.beginObject("short block", Mobility::movable);
  addBox(mesh, {{0.33, 0.0, 0.35}, turnByDegrees(-17.0)}, {-0.3, 0.0, -0.3}, {0.3, 0.6, 0.3}, white);
  mesh.beginObject("tall block", Mobility::movable);
  addBox(mesh, {{-0.35, 0.0, -0.3}, turnByDegrees(18.0)}, {-0.3, 0.0, -0.3}, {0.3, 1.2, 0.3}, white);
  addPanel(mesh, {0.0, 2.0, 0.0}, {0.235, 0.19}, white, lamp);
  Scene scene = mesh.finish("cornell");
  // as at Cornell, before the open side: 800 of 555 units away, a lens of 35 mm for 25
  addCamera(scene, "front", {0.0, 1.0, 3.88}, {0.0, 1.0, 0.0}, 39.3);
  return scene;
}

// Two rooms of 4 x 2.5 x 4 m, 10 cm apart; the lamp hangs in the left one.
Scene makeTwoRooms(uint64_t seed) {
  MeshBuilder mesh;
  const uint32_t white = addPaint(mesh, glm::vec3(0.7f)), floor = addPaint(mesh, {0.35f, 0.25f, 0.18f}),
                 cloth = addPaint(mesh, {0.3f, 0.12f, 0.15f});
  const uint32_t lamp = mesh.addMaterial({glm::vec3(0.8f), glm::vec3(10.0f, 9.2f, 8.0f), false});
  const double half_wall = 0.5 * kShell_m, reach = half_wall + 4.0;
  // one block with two rooms carved into it: the wall between is what they leave
  BrushGrid rooms;
  rooms.fill({-reach - kShell_m, -kShell_m, -2.0 - kShell_m}, {reach + kShell_m, 2.5 + kShell_m, 2.0 + kShell_m},
             BrushMaterials(white, floor, white));
  rooms.carve({-reach, 0.0, -2.0}, {-half_wall, 2.5, 2.0});
  rooms.carve({half_wall, 0.0, -2.0}, {reach, 2.5, 2.0});
  // seed 0 has no opening: any light in the right room is a leak
  if (seed == 1) rooms.carve({-half_wall, 0.0, -0.45}, {half_wall, 2.0, 0.45});
  rooms.emitObject(mesh, "rooms", Mobility::structure);
  for (const double x : {-reach + 0.6, reach - 0.6}) {
    mesh.beginObject("chest", Mobility::movable);
    addBox(mesh, {{x, 0.0, 1.2}, {}}, {-0.4, 0.0, -0.5}, {0.4, 0.7, 0.5}, cloth);
  }
  addPanel(mesh, {-0.5 * reach, 2.5, 0.0}, {0.5, 0.2}, white, lamp);
  Scene scene = mesh.finish("two_rooms");
  addCamera(scene, "lit room", {-0.4, 1.6, -1.7}, {-reach, 0.9, 1.2}, 60.0);
  addCamera(scene, "dark room", {reach - 0.3, 1.6, -1.7}, {0.4, 0.9, 0.9}, 60.0);
  return scene;
}

struct BuiltIn {
  const char* name;
  uint64_t seed_count;
  Scene (*make)(uint64_t);
};
constexpr std::array<BuiltIn, 3> kBuiltIn = {
    {{"cornell", 1, makeCornell}, {"two_rooms", 2, makeTwoRooms}, {"daylight", kDaylightSeeds, makeDaylight}}};

}  // namespace

const std::vector<std::string>& proceduralFamilies() {
  static const std::vector<std::string> names = namesOf(kFamilies);
  return names;
}

Scene makeProceduralScene(const std::string& family, uint64_t seed) {
  for (size_t i = 0; i < kFamilies.size(); ++i) {
    if (family != kFamilies[i].name) continue;
    Level level(mixSeed(0x6c6576656c, i, seed));
    kFamilies[i].build(level);
    Scene scene = level.mesh.finish(family + "-" + std::to_string(seed));
    const Daylight daylight = drawDaylight(mixSeed(kDaylightStream, i, seed));
    scene.light.sky = daylight.sky;
    scene.light.suns = daylight.suns;
    for (const View& view : level.views) addCamera(scene, view.name, view.eye, view.look, kViewDegrees);
    return scene;
  }
  throw UsageError("scene family", fmt::format("one of {}", fmt::join(proceduralFamilies(), ", ")), family);
}

void addPanel(MeshBuilder& mesh, const glm::dvec3& middle, const glm::dvec2& half, uint32_t housing, uint32_t lamp) {
  BrushGrid panel;
  panel.fill(middle + glm::dvec3(-half.x, -0.02, -half.y), middle + glm::dvec3(half.x, 0.0, half.y),
             BrushMaterials(housing, housing, lamp));
  panel.emitObject(mesh, "lamp", Mobility::movable);
}

void addCamera(Scene& scene, const std::string& name, const glm::dvec3& eye, const glm::dvec3& look, double fov_degrees) {
  const glm::dvec3 forward = glm::normalize(look - eye), right = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 1.0, 0.0)));
  scene.viewpoints.push_back({name, glm::vec3(eye - scene.origin_m), glm::vec3(forward), glm::vec3(glm::cross(right, forward)),
                              static_cast<float>(glm::radians(fov_degrees))});
}

const std::vector<std::string>& builtInScenes() {
  static const std::vector<std::string> names = namesOf(kBuiltIn);
  return names;
}

Scene makeBuiltInScene(const std::string& name, uint64_t seed) {
  for (const BuiltIn& scene : kBuiltIn) {
    if (name != scene.name) continue;
    if (seed >= scene.seed_count)
      throw UsageError("scene " + name, "a seed below " + std::to_string(scene.seed_count), std::to_string(seed));
    Scene made = scene.make(seed);
    made.id = name + "-" + std::to_string(seed);
    return made;
  }
  throw UsageError("scene", "cornell, two_rooms or daylight", name);
}

}  // namespace nlg
