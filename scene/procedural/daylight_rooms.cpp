// The built-in scenes "daylight": rooms beside daylight, where what lies behind a wall is a hundred times brighter.
#include <array>
#include <vector>

#include "scene/procedural/brush_grid.h"
#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"
#include "scene/procedural/procedural.h"

namespace nlg {
namespace {

constexpr double kGroundTop_m = -0.1, kMargin_m = 3.0;  // of the ground, and how far it reaches around what stands on it

using Point = glm::dvec3;

// A place in the making. The house is one closed solid, and so is the ground; x points east, z south.
struct Site {
  explicit Site(uint64_t seed) : level(mixSeed(0x6461796c69676874, seed)) {
    sky = {glm::vec3(0.55f, 0.75f, 1.1f), glm::vec3(1.0f, 1.08f, 1.2f), glm::vec3(0.30f, 0.27f, 0.22f)};
    shineSun(25.0, 40.0);
  }

  // The sun's direction: degrees from south to east, and above the horizon.
  void shineSun(double east, double height) {
    const double turn = glm::radians(east), rise = glm::radians(height);
    Sun sun;
    sun.to_sun = glm::vec3(glm::dvec3(std::sin(turn) * std::cos(rise), std::sin(rise), std::cos(turn) * std::cos(rise)));
    sun.irradiance = glm::vec3(14.0f, 13.0f, 11.2f);
    suns = {sun};
  }

  // Walls, floor and ceiling around a room, and its air: walls are what no room's air is, so that two rooms have one wall between
  // them.
  void build(const Point& low, const Point& high, double wall_m) {
    house.fill(low - wall_m, high + wall_m, level.roomFaces());
    rooms.push_back({low, high});
  }
  void open(const Point& low, const Point& high) { rooms.push_back({low, high}); }

  // A leaf in an opening of 90 x 205 cm, hinged at its west end in the wall's southern face and opened to the south, gap_m wide.
  void hangDoor(const Point& hinge, double gap_m) {
    constexpr double kWidth_m = 0.88, kThick_m = 0.04;
    level.mesh.beginObject("door", Mobility::movable);
    const double turn = std::asin((gap_m + kThick_m) / kWidth_m);
    addBox(level.mesh, {hinge, turnByDegrees(-glm::degrees(turn))}, {0.0, 0.0, -kThick_m}, {kWidth_m, 2.03, 0.0},
           level.palette.wood);
  }

  void layGround(const Point& low, const Point& high) {
    const double bottom = std::min(low.y - 0.5, kGroundTop_m - 0.5);
    earth.fill({low.x - kMargin_m, bottom, low.z - kMargin_m}, {high.x + kMargin_m, kGroundTop_m, high.z + kMargin_m},
               level.palette.ground);
  }

  Scene finish(const std::string& id) {
    Point low(1e9), high(-1e9);
    for (const auto& [from, to] : rooms) low = glm::min(low, from), high = glm::max(high, to);
    layGround(low, high);
    for (const auto& [from, to] : rooms) {
      house.carve(from, to);
      earth.carve(from, to);  // of cellars
    }
    for (const auto& [from, to] : pillars) house.fill(from, to, level.palette.stone);
    earth.emitObject(level.mesh, "ground", Mobility::structure);
    house.emitObject(level.mesh, "house", Mobility::structure);
    const uint32_t ground = level.palette.ground;
    Scene scene = level.mesh.finish(id);
    for (uint32_t m = 0; m < scene.materials.size(); ++m) scene.materials[m].double_sided = are_sheets && m != ground;
    scene.light.sky = sky;
    scene.light.suns = suns;
    scene.light.lamps = lamps;
    for (const View& view : views) addCamera(scene, view.name, view.eye, view.look, kViewDegrees);
    return scene;
  }

  Level level;
  BrushGrid house, earth;
  std::vector<std::pair<Point, Point>> rooms, pillars;  // air, and what stands in it from wall to wall
  bool are_sheets = false;                              // the house's faces are seen from both sides: its walls are hollow
  Sky sky;
  std::vector<Sun> suns;
  std::vector<Lamp> lamps;
  std::vector<View> views;
};

// One room of 5 x 3 x 4 m, walls of 20 cm, a window of 1.2 x 1.2 m to the south.
void oneWindow(Site& site) {
  site.build({0, 0, 0}, {5, 3, 4}, 0.2);
  site.open({1.9, 0.9, 4}, {3.1, 2.1, 4.2});
  site.views = {{"room", {0.5, 1.6, 3.5}, {3.5, 1.0, 0.5}}, {"window", {0.6, 1.6, 0.5}, {2.8, 1.2, 4.0}}};
}

void partition(Site& site) {
  site.shineSun(-50.0, 30.0);
  site.build({0, 0, 0}, {6, 2.6, 5}, 0.25);
  site.open({0.5, 0.3, 5}, {2.6, 1.6, 5.25});
  site.pillars = {{{3.0, 0, 0}, {3.1, 2.6, 3.6}}};
  site.views = {{"bright side", {2.6, 1.6, 4.6}, {0.6, 0.9, 0.6}}, {"dark side", {5.6, 1.6, 4.6}, {3.4, 0.9, 0.4}}};
}

void manyWindows(Site& site) {
  site.build({0, 0, 0}, {8, 2.8, 5}, 0.25);
  for (const double x : {0.8, 3.4, 6.0}) site.open({x, 0.9, 5}, {x + 1.2, 2.2, 5.25});
  for (const double z : {0.8, 3.0}) site.open({-0.25, 0.9, z}, {0, 2.2, z + 1.0});
  site.open({5.0, 1.4, -0.25}, {6.4, 2.2, 0});
  site.views = {{"room", {7.5, 1.6, 0.5}, {0.5, 1.0, 4.0}}, {"east end", {2.0, 1.6, 2.5}, {8.0, 1.2, 1.0}}};
}

void enfilade(Site& site) {
  for (int room = 0; room < 3; ++room) site.build({4.15 * room, 0, 0}, {4.15 * room + 4.0, 3, 4}, 0.15);
  for (int door = 0; door < 2; ++door) site.open({4.15 * door + 4.0, 0, 1.5}, {4.15 * door + 4.15, 2.1, 2.5});
  for (const double x : {0.5, 2.3}) site.open({x, 0, 4}, {x + 1.2, 2.3, 4.15});
  site.views = {{"last", {12.0, 1.6, 3.5}, {8.4, 1.0, 1.0}}, {"first", {3.6, 1.6, 0.5}, {0.5, 1.0, 4.0}}};
}

// Behind the room with a window a dark one, its door 10 cm open.
void innerDoorAjar(Site& site) {
  site.build({0, 0, 0}, {4, 2.6, 4}, 0.2);
  site.build({0, 0, -3.65}, {4, 2.6, -0.15}, 0.15);
  site.open({1.4, 0.8, 4}, {2.8, 2.1, 4.2});
  site.open({2.5, 0, -0.15}, {3.4, 2.05, 0});
  site.hangDoor({2.51, 0.0, 0.0}, 0.10);
  site.views = {{"dark room", {0.5, 1.6, -3.2}, {3.2, 1.0, -0.2}}, {"bright room", {0.5, 1.6, 3.5}, {3.0, 1.0, 0.2}}};
}

void outerDoorAjar(Site& site) {
  site.build({0, 0, 0}, {4, 2.5, 3.5}, 0.2);
  site.open({1.5, 0, 3.5}, {2.4, 2.05, 3.7});
  site.hangDoor({1.51, 0.0, 3.7}, 0.08);
  site.views = {{"room", {0.5, 1.6, 0.5}, {2.6, 1.0, 3.5}}, {"back", {2.0, 1.6, 3.2}, {1.0, 0.8, 0.2}}};
}

void cellar(Site& site) {
  site.build({0, -2.4, 0}, {5, -0.2, 4}, 0.2);
  site.build({0, 0, 0}, {5, 2.6, 4}, 0.2);
  site.open({1.6, 0.7, 4}, {3.4, 2.1, 4.2});
  site.views = {{"cellar", {0.5, -0.8, 3.5}, {4.0, -1.8, 0.5}}, {"room", {0.5, 1.6, 0.5}, {3.5, 0.8, 3.8}}};
}

// The same, and a hatch of 80 x 80 cm between them; a second cellar without one.
void cellarsWithHatch(Site& site) {
  site.build({-3.2, -2.4, 0}, {-0.2, -0.2, 4}, 0.2);
  cellar(site);
  site.open({3.6, -0.2, 0.6}, {4.4, 0.0, 1.4});
}

// A lamp 40 cm from a wall of 10 cm; behind it no light at all.
void lampBehindWall(Site& site) {
  const uint32_t white = site.level.palette.ceiling, lamp = site.level.palette.lamp;
  site.build({0, 0, 0}, {4, 2.6, 4}, 0.2);
  site.build({4.1, 0, 0}, {7.1, 2.6, 4}, 0.1);
  addPanel(site.level.mesh, {3.6, 2.6, 2.0}, {0.2, 0.6}, white, lamp);
  site.views = {{"bright room", {0.5, 1.6, 3.5}, {3.5, 1.2, 0.8}}, {"dark room", {6.6, 1.6, 3.5}, {4.2, 1.2, 0.8}}};
}

void corridorAroundLamp(Site& site) {
  const uint32_t white = site.level.palette.ceiling, lamp = site.level.palette.lamp;
  site.build({0, 0, 0}, {8, 2.6, 7}, 0.2);
  site.pillars = {{{1.9, 0, 1.9}, {6.1, 2.6, 2.0}},
                  {{1.9, 0, 5.0}, {6.1, 2.6, 5.1}},
                  {{1.9, 0, 2.0}, {2.0, 2.6, 5.0}},
                  {{6.0, 0, 2.0}, {6.1, 2.6, 4.1}},
                  {{6.0, 2.05, 4.1}, {6.1, 2.6, 5.0}}};
  addPanel(site.level.mesh, {4.0, 2.6, 3.5}, {0.6, 0.6}, white, lamp);
  site.views = {{"corridor", {0.8, 1.6, 6.4}, {1.4, 1.2, 0.5}}, {"door", {7.6, 1.6, 0.6}, {6.3, 1.2, 5.5}}};
}

// Two rooms and a doorway, all walls of 5 cm; a window in one of them.
void thinWalls(Site& site) {
  site.build({0, 0, 0}, {4, 2.5, 4}, 0.05);
  site.build({4.05, 0, 0}, {7.05, 2.5, 4}, 0.05);
  site.open({1.2, 0.8, 4}, {2.8, 2.0, 4.05});
  site.open({4, 0, 0.4}, {4.05, 2.05, 1.3});
  site.views = {{"bright room", {0.5, 1.6, 0.5}, {3.0, 1.0, 4.0}}, {"dark room", {6.6, 1.6, 3.5}, {4.2, 1.0, 0.6}}};
}

void thickWalls(Site& site) {
  site.shineSun(-20.0, 25.0);
  site.build({0, 0, 0}, {4, 3, 4}, 0.6);
  site.build({4.6, 0, 0}, {8.6, 3, 4}, 0.6);
  site.open({1.6, 1.0, 4}, {2.4, 2.2, 4.6});
  site.open({6.4, 1.8, -0.6}, {6.8, 2.4, 0});
  site.open({4, 0, 2.6}, {4.6, 2.1, 3.5});
  site.views = {{"south room", {0.5, 1.6, 0.5}, {2.5, 1.4, 4.0}}, {"north room", {8.2, 1.6, 3.5}, {6.0, 1.6, 0.2}}};
}

// Walls, floor and ceiling are sheets around hollows of 20 cm, and of 12 cm between the two rooms.
void hollowWalls(Site& site) {
  site.are_sheets = true;
  site.build({0, 0, 0}, {4.5, 2.6, 4}, 0.2);
  site.build({4.62, 0, 0}, {7.6, 2.6, 4}, 0.2);
  site.open({1.4, 0.8, 4}, {3.0, 2.1, 4.2});
  site.open({4.5, 0, 1.2}, {4.62, 2.05, 2.1});
  site.views = {{"bright room", {0.5, 1.6, 0.5}, {3.2, 1.0, 4.0}}, {"dark room", {7.2, 1.6, 3.5}, {4.8, 1.0, 0.6}}};
}

void hollowCorner(Site& site) {
  site.are_sheets = true;
  site.build({0, 0, 0}, {6, 2.8, 3}, 0.3);
  site.build({0, 0, 3}, {2.8, 2.8, 6}, 0.3);
  site.open({6, 0.6, 0.8}, {6.3, 2.2, 2.2});
  site.shineSun(75.0, 25.0);
  site.views = {{"window", {0.6, 1.6, 2.4}, {6.0, 1.2, 1.0}}, {"corner", {0.6, 1.6, 5.4}, {2.4, 1.2, 2.0}}};
}

// A street in the sun between two high walls; behind one of them a hall with a low door at its far end.
void streetAndHall(Site& site) {
  site.shineSun(70.0, 55.0);
  site.build({0, 0, 0}, {8, 4, 6}, 0.2);
  site.open({6.8, 0, -0.2}, {7.6, 2.1, 0});
  site.open({0, 0, 6.2}, {8, 4, 9.2});
  site.house.fill({-0.2, -0.2, 9.2}, {8.2, 6.0, 9.4}, site.level.palette.stone);
  site.house.fill({-0.2, 4.2, 6.0}, {8.2, 6.0, 6.2}, site.level.palette.stone);
  site.views = {{"hall", {0.6, 1.6, 5.4}, {7.0, 1.4, 0.4}}, {"street", {0.5, 1.6, 7.8}, {8.0, 1.2, 7.0}}};
}

void lampsAtDusk(Site& site) {
  site.suns.clear();
  for (glm::vec3* of : {&site.sky.zenith, &site.sky.horizon, &site.sky.ground}) *of *= 0.02f;
  site.build({0, 0, 0}, {9, 3.5, 5}, 0.15);
  site.open({-0.15, 0, 0.6}, {0, 2.4, 2.6});
  for (const double x : {1.5, 4.5, 7.5})
    site.lamps.push_back({glm::vec3(glm::dvec3(x, 2.8, 5.75)), glm::vec3(9.0f, 7.0f, 4.0f), 0.06f});
  site.views = {{"hall", {8.4, 1.6, 4.4}, {0.5, 1.2, 1.0}}, {"street", {9.0, 1.6, 7.4}, {2.0, 1.0, 5.2}}};
}

void skylight(Site& site) {
  site.shineSun(30.0, 60.0);
  site.build({0, 0, 0}, {6, 3.2, 6}, 0.2);
  site.open({2.0, 3.2, 2.4}, {3.4, 3.4, 3.8});
  site.views = {{"room", {0.5, 1.6, 5.5}, {4.0, 1.2, 0.8}}, {"skylight", {5.4, 1.6, 5.4}, {2.6, 3.0, 2.8}}};
}

void lightWell(Site& site) {
  site.shineSun(10.0, 62.0);
  site.build({0, 0, 0}, {7, 2.6, 5}, 0.2);
  site.build({0, 2.8, 0}, {7, 5.4, 5}, 0.2);
  site.open({2.6, 2.6, 1.6}, {4.4, 2.8, 3.4});
  site.open({2.8, 5.4, 1.8}, {4.2, 5.6, 3.2});
  site.views = {{"below", {0.5, 1.6, 4.5}, {4.5, 1.2, 1.5}}, {"gallery", {6.5, 4.4, 4.5}, {2.0, 3.6, 1.0}}};
}

// A corridor with a window at one end, and a leg around the corner that sees none of it.
void cornerCorridor(Site& site) {
  site.build({0, 0, 0}, {1.6, 2.5, 7}, 0.2);
  site.build({1.6, 0, 0}, {7.6, 2.5, 1.6}, 0.2);
  site.open({0.3, 0.8, 7}, {1.3, 2.0, 7.2});
  site.views = {{"far leg", {7.2, 1.6, 0.8}, {0.5, 1.2, 0.8}}, {"window", {0.8, 1.6, 0.6}, {0.8, 1.3, 7.0}}};
}

void hairpinCorridor(Site& site) {
  site.shineSun(-60.0, 20.0);
  site.build({0, 0, 0}, {8, 2.5, 1.4}, 0.2);
  site.build({6.6, 0, 1.4}, {8, 2.5, 2.9}, 0.2);
  site.build({0, 0, 1.5}, {6.6, 2.5, 2.9}, 0.1);
  site.open({-0.2, 0.2, 0.3}, {0, 2.2, 1.1});
  site.views = {{"way in", {0.4, 1.6, 0.7}, {8.0, 1.3, 1.2}}, {"dead end", {0.4, 1.6, 2.2}, {7.0, 1.2, 2.2}}};
}

void furnish(Site& site) {
  Level& level = site.level;
  addSofa(level, {{1.4, 0, 0.5}, {}}, {2.0, 0.85, 0.9});
  addShelf(level, {{4.7, 0, 1.4}, turnByDegrees(-90.0)}, {1.6, 2.0, 0.4});
  addCupboard(level, {{0.4, 0, 3.0}, turnByDegrees(90.0)}, {1.2, 1.2, 0.6});
  addDiningGroup(level, {{2.6, 0, 2.4}, {}}, 1.4, 0.9);
}

// A furnished room with a window; a spot 15 cm from the wall shines down it.
void spotByWall(Site& site) {
  site.build({0, 0, 0}, {5, 2.6, 4}, 0.2);
  site.open({1.8, 0.9, 4}, {3.2, 2.1, 4.2});
  furnish(site);
  const auto cosOf = [](double degrees) { return static_cast<float>(std::cos(glm::radians(degrees))); };
  site.lamps.push_back(
      {glm::vec3(2.9f, 2.5f, 0.15f), glm::vec3(4.0f, 3.4f, 2.6f), 0.03f, glm::vec3(0.0f, -1.0f, 0.0f), cosOf(25.0), cosOf(40.0)});
  site.views = {{"spot", {0.8, 1.6, 3.5}, {3.2, 1.2, 0.0}}, {"window", {4.2, 1.6, 0.5}, {1.6, 1.0, 4.0}}};
}

void panelByWall(Site& site) {
  site.shineSun(-30.0, 22.0);
  site.build({0, 0, 0}, {5, 2.6, 4}, 0.12);
  site.build({0, 0, -3.12}, {5, 2.6, -0.12}, 0.12);
  site.open({5, 1.0, 0.8}, {5.12, 2.0, 1.8});
  furnish(site);
  BrushGrid panel;
  panel.fill({2.6, 1.2, 0.0}, {3.6, 1.8, 0.04}, site.level.palette.lamp);
  panel.emitObject(site.level.mesh, "panel", Mobility::movable);
  site.views = {{"panel", {0.8, 1.6, 3.5}, {3.2, 1.2, 0.0}}, {"behind", {0.5, 1.6, -2.8}, {4.0, 1.2, -0.2}}};
}

// Pillars in a hall, windows in walls of 60 cm.
void pillarsAndReveals(Site& site) {
  site.build({0, 0, 0}, {8, 3.5, 6}, 0.6);
  for (const double x : {1.4, 5.4}) site.open({x, 0.9, 6}, {x + 1.2, 2.5, 6.6});
  for (const double x : {2.2, 5.4}) {
    for (const double z : {1.6, 4.0}) site.pillars.push_back({{x, 0, z}, {x + 0.4, 3.5, z + 0.4}});
  }
  site.views = {{"hall", {0.6, 1.6, 0.6}, {6.5, 1.4, 5.5}}, {"reveal", {3.6, 1.6, 3.2}, {2.0, 1.6, 6.4}}};
}

// Slits that widen inward, between half pillars.
void embrasures(Site& site) {
  site.shineSun(-10.0, 18.0);
  site.build({0, 0, 0}, {7, 4, 3}, 0.9);
  for (const double x : {0.9, 3.3, 5.7}) {
    for (int step = 0; step < 3; ++step)
      site.open({x - 0.1 * step, 1.2, 3.6 - 0.3 * step}, {x + 0.2 + 0.1 * step, 2.8, 3.9 - 0.3 * step});
  }
  for (const double x : {2.0, 4.4}) site.pillars.push_back({{x, 0, 2.6}, {x + 0.5, 4, 3}});
  site.views = {{"slits", {0.5, 1.6, 0.5}, {4.5, 1.8, 3.0}}, {"back", {6.6, 1.6, 2.4}, {1.0, 1.4, 0.2}}};
}

// Bars of 2 cm, 12 cm apart, in a wide window.
void grille(Site& site) {
  site.shineSun(15.0, 30.0);
  site.build({0, 0, 0}, {5, 2.8, 4}, 0.2);
  site.open({0.8, 0.5, 4}, {4.0, 2.3, 4.2});
  BrushGrid bars;
  for (double x = 0.9; x < 4.0; x += 0.14) bars.fill({x, 0.4, 4.09}, {x + 0.02, 2.4, 4.11}, site.level.palette.metal);
  for (const double y : {1.1, 1.7}) bars.fill({0.7, y, 4.09}, {4.1, y + 0.03, 4.11}, site.level.palette.metal);
  bars.emitObject(site.level.mesh, "bars", Mobility::structure);
  site.views = {{"room", {0.5, 1.6, 0.5}, {3.5, 0.8, 4.0}}, {"floor", {4.5, 1.6, 3.5}, {1.0, 0.2, 0.8}}};
}

void louvres(Site& site) {
  site.shineSun(40.0, 28.0);
  site.build({0, 0, 0}, {4, 2.6, 5}, 0.15);
  site.open({0.6, 0.3, 5}, {3.4, 2.4, 5.15});
  BrushGrid slats;
  for (double y = 0.4; y < 2.35; y += 0.1) slats.fill({0.5, y, 5.02}, {3.5, y + 0.012, 5.12}, site.level.palette.wood);
  slats.emitObject(site.level.mesh, "slats", Mobility::structure);
  site.views = {{"room", {0.5, 1.6, 0.5}, {3.0, 1.0, 5.0}}, {"back", {3.5, 1.6, 4.5}, {0.6, 1.2, 0.4}}};
}

constexpr std::array<void (*)(Site&), kDaylightSeeds> kKinds = {
    oneWindow,        partition,         manyWindows,        enfilade,  innerDoorAjar,  outerDoorAjar,   cellar,
    cellarsWithHatch, lampBehindWall,    corridorAroundLamp, thinWalls, thickWalls,     hollowWalls,     hollowCorner,
    streetAndHall,    lampsAtDusk,       skylight,           lightWell, cornerCorridor, hairpinCorridor, spotByWall,
    panelByWall,      pillarsAndReveals, embrasures,         grille,    louvres};

}  // namespace

Scene makeDaylight(uint64_t seed) {
  Site site(seed);
  kKinds[seed](site);
  return site.finish("daylight");
}

}  // namespace nlg
