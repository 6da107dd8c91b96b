// The families "kitchen", "gallery" and "meeting": a room whose fittings are plates that stand a few centimetres before its walls
// and before each other. Houses and furnished rooms have no such places: a plate hides them from all probes but one.
#include <vector>

#include "scene/procedural/building.h"
#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"

namespace nlg {
namespace {

constexpr double kBoard_m = 0.02;

struct Box {
  glm::dvec3 low, high;
};

enum class Plates { boards, sheets };  // solid, or without thickness and seen from both sides
enum class Doors { shut, none };

struct Fittings {
  uint32_t carcass, front, panel;
  Plates plates;
  bool have_backs;
  double gap_m;  // between a front and what it closes
};

Fittings drawFittings(Level& level) {
  Fittings fittings{};
  fittings.plates = level.random.chance(0.5) ? Plates::sheets : Plates::boards;
  fittings.have_backs = level.random.chance(0.5);
  fittings.gap_m = level.random.uniform(0.004, 0.04);
  const glm::vec3 paints[] = {{0.72f, 0.70f, 0.66f}, {0.45f, 0.29f, 0.15f}, {0.30f, 0.38f, 0.36f}, {0.60f, 0.48f, 0.34f}};
  for (uint32_t* of : {&fittings.carcass, &fittings.front, &fittings.panel})
    *of = level.mesh.addMaterial({paints[level.random.below(4)], glm::vec3(0.0f), fittings.plates == Plates::sheets});
  return fittings;
}

// One object of plates, each given as a board; a sheet lies in the middle of its board.
void addPlates(Level& level, const char* name, const Placement& at, const std::vector<Box>& plates, uint32_t material,
               Plates make) {
  if (make == Plates::boards) {
    BrushGrid boards;
    for (const Box& plate : plates) boards.fill(plate.low, plate.high, material);
    return boards.emitObject(level.mesh, name, Mobility::movable, at);
  }
  level.mesh.beginObject(name, Mobility::movable);
  for (const Box& plate : plates) {
    const glm::dvec3 size = plate.high - plate.low;
    const int thin = size.x < size.y ? (size.x < size.z ? 0 : 2) : (size.y < size.z ? 1 : 2);
    const auto corner = [&](double u, double v) {
      glm::dvec3 share(0.5);
      share[(thin + 1) % 3] = u;
      share[(thin + 2) % 3] = v;
      return level.mesh.addVertex(at, plate.low + share * size);
    };
    const uint32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
    level.mesh.addQuad(a, b, c, d, material);
  }
}

// On a wall's inside, looking into the room; along and height from the wall's start and from the floor.
Placement onWall(const Rect& room, Side wall, double along, double height, double before) {
  const Rect at = room.strip(wall, room.start(wall) + along, room.start(wall) + along, before, before);
  return {{at.x0, height, at.z0}, turnByDegrees(degreesAt(wall))};
}

// An open box with a shelf, and one or two fronts before it. The placement is the middle of the lower back edge.
void addUnit(Level& level, const Placement& at, const glm::dvec3& size, const Fittings& fittings, Doors doors) {
  const double x = 0.5 * size.x, t = kBoard_m, shelf = size.y * level.random.uniform(0.35, 0.65);
  std::vector<Box> boards = {{{-x, 0, 0}, {-x + t, size.y, size.z}},
                             {{x - t, 0, 0}, {x, size.y, size.z}},
                             {{-x, 0, 0}, {x, t, size.z}},
                             {{-x, size.y - t, 0}, {x, size.y, size.z}},
                             {{-x, shelf, 0}, {x, shelf + t, 0.8 * size.z}}};
  if (fittings.have_backs) boards.push_back({{-x, 0, 0}, {x, size.y, t}});
  addPlates(level, "carcass", at, boards, fittings.carcass, fittings.plates);
  if (doors == Doors::none) return;
  const double z = size.z + fittings.gap_m, slit = 0.004;
  const int front_count = size.x > 0.7 ? 2 : 1;
  std::vector<Box> fronts;
  for (int front = 0; front < front_count; ++front) {
    const double from = -x + size.x * front / front_count, to = -x + size.x * (front + 1) / front_count;
    fronts.push_back({{from + slit, slit, z}, {to - slit, size.y - slit, z + t}});
  }
  addPlates(level, "front", at, fronts, fittings.front, fittings.plates);
}

// Units side by side along a wall under a worktop, and cupboards above them but before the window.
void addRun(Level& level, const Rect& room, Side wall, double from, double to, const Fittings& fittings, const Box& window) {
  constexpr double kDepth_m = 0.56, kPlinth_m = 0.1, kTop_m = 0.86, kCupboards_m = 1.45;
  const double off_wall = level.random.uniform(0.005, 0.05), height = level.pick(0.6, 0.9);
  const int count = std::max(1, static_cast<int>((to - from) / 0.6));
  const double width = (to - from) / count;
  for (int unit = 0; unit < count; ++unit) {
    const double along = from + (unit + 0.5) * width;
    const glm::dvec3 base(width - 0.006, kTop_m - kPlinth_m, kDepth_m), upper(width - 0.006, height, level.pick(0.3, 0.35));
    addUnit(level, onWall(room, wall, along, kPlinth_m, off_wall), base, fittings,
            level.random.chance(0.15) ? Doors::none : Doors::shut);
    const bool is_before_window = along + 0.5 * width > window.low.x && along - 0.5 * width < window.high.x;
    if (!is_before_window)
      addUnit(level, onWall(room, wall, along, kCupboards_m, off_wall), upper, fittings,
              level.random.chance(0.1) ? Doors::none : Doors::shut);
  }
  const double half = 0.5 * (to - from);
  addPlates(level, "worktop", onWall(room, wall, from + half, 0.0, off_wall),
            {{{-half, kTop_m, 0}, {half, kTop_m + 0.04, kDepth_m + 0.06}}, {{-half, 0.01, 0.5}, {half, kPlinth_m, 0.52}}},
            level.palette.stone, Plates::boards);
}

// Panels and frames before a wall, one after another; none reaches over an edge of it.
void hangPanels(Level& level, const Rect& room, Side wall, double most_width, const Fittings& fittings, double low, double high) {
  for (double along = level.pick(0.2, 0.8); along + 0.4 < room.length(wall);) {
    const double width = std::min(level.pick(0.4, most_width), room.length(wall) - along - 0.1);
    const double height = std::min(level.pick(0.4, 2.6), high - low), before = level.random.uniform(0.03, 0.08);
    const double foot = low + (high - low - height) * level.random.uniform();
    addPlates(level, "panel", onWall(room, wall, along + 0.5 * width, foot, before),
              {{{-0.5 * width, 0, 0}, {0.5 * width, height, kBoard_m}}}, fittings.panel, fittings.plates);
    along += width + level.pick(0.1, 0.8);
  }
}

// A closed room on its ground, and closed rooms without light behind its walls at these sides, as corridors have them: what a probe
// there holds is black. Windows and doors are still to be carved, and the shell to be emitted.
Building makeRoom(Level& level, const glm::dvec3& low, const glm::dvec3& high, const std::vector<Side>& dark_sides) {
  Building building;
  building.wall_m = level.random.chance(0.5) ? 0.02 : level.pick(0.05, 0.2);  // many a file's walls are sheets, too
  building.base_m = -building.wall_m;
  const double width = level.pick(low.x, high.x), depth = level.pick(low.z, high.z);
  building.outer = Rect{-0.5 * width, -0.5 * depth, 0.5 * width, 0.5 * depth}.grown(building.wall_m);
  building.clear_m = {level.pick(low.y, high.y)};
  addGround(level, building, level.pick(2.5, 3.5));
  fillShell(level, building);
  const Rect& out = building.outer;
  const double wall = building.wall_m, reach = level.pick(1.0, 1.4);
  for (const Side side : dark_sides) {
    const double start = out.start(side), end = start + out.length(side);
    const Rect around = out.strip(side, start, end, -reach - wall), air = out.strip(side, start + wall, end - wall, -reach);
    building.shell.fill({around.x0, -wall, around.z0}, {around.x1, building.roofHeight(), around.z1}, level.roomFaces());
    building.shell.carve({air.x0, 0.0, air.z0}, {air.x1, building.clear_m[0], air.z1});
  }
  return building;
}

void addLamps(Level& level, const Building& building, int count) {
  const Rect in = building.inner();
  for (int lamp = 0; lamp < count; ++lamp)
    addCeilingLamp(level, {{in.x0 + in.width() * (lamp + 0.5) / count, building.clear_m[0], in.middle().y}, {}});
}

}  // namespace

void buildKitchen(Level& level) {
  const Fittings fittings = drawFittings(level);
  Building building = makeRoom(level, {3.8, 2.4, 3.4}, {5.4, 2.8, 4.6}, {Side::north});
  const Rect in = building.inner();
  const double window = level.pick(1.0, 1.6);
  carveHole(building, 0, Side::west, window, window + 1.2, 1.0, 2.1, 0.0);
  carveHole(building, 0, Side::south, 0.8, in.width() - 0.8, 0.7, 2.2, 0.0);
  carveDoor(building, Side::east, 0, level.pick(0.8, 2.0), 0.9);
  building.shell.emitObject(level.mesh, "shell", Mobility::structure);
  // units along two walls; those of the west leave the window free
  addRun(level, in, Side::north, 0.02, in.width() - 0.75, fittings, {glm::dvec3(-1.0), glm::dvec3(-1.0)});
  addRun(level, in, Side::west, 0.66, in.depth() - 0.6, fittings, {glm::dvec3(window), glm::dvec3(window + 1.2)});
  addUnit(level, onWall(in, Side::north, in.width() - 0.36, 0.03, 0.06), {0.6, 1.8, 0.58}, fittings, Doors::shut);  // the fridge
  addDiningGroup(level, {{in.x1 - 1.3, 0.0, in.z1 - 1.2}, {}}, 1.2, 0.8);
  addLamps(level, building, 1);
  level.views = {{"corner", {in.x1 - 0.6, 1.6, in.z1 - 0.6}, {in.x0 + 0.4, 1.2, in.z0 + 0.4}},
                 {"cupboards", {in.middle().x + 0.4, 1.6, in.middle().y + 0.4}, {in.x0 + 0.6, 1.5, in.z0}},
                 {"units", {in.middle().x + 0.6, 1.5, in.middle().y + 0.2}, {in.x0, 0.6, in.middle().y}}};
}

void buildGallery(Level& level) {
  const Fittings fittings = drawFittings(level);
  Building building = makeRoom(level, {7.0, 3.0, 5.0}, {11.0, 3.6, 7.0}, {Side::north, Side::west, Side::south});
  const Rect in = building.inner();
  const double clear = building.clear_m[0];
  carveHole(building, 0, Side::east, 0.5 * in.depth() - 1.0, 0.5 * in.depth() + 1.0, 0.0, 2.6, 0.0);
  building.shell.emitObject(level.mesh, "shell", Mobility::structure);
  // a wall that stands free, and one that ends in the room from either side; panels hang on both faces of each
  const double end = std::min(level.pick(1.2, 2.0), 0.5 * in.depth() - 1.0), west = in.x0 + level.pick(2.2, 3.0),
               east = in.x1 - level.pick(1.6, 2.4), thick = level.pick(0.05, 0.15);
  for (const Rect& wall : {Rect{in.x0 + 1.6, in.middle().y - 0.5 * thick, in.middle().x + 0.4, in.middle().y + 0.5 * thick},
                           Rect{west, in.z0, west + thick, in.z0 + end}, Rect{east, in.z1 - end, east + thick, in.z1}}) {
    level.mesh.beginObject("wall", Mobility::structure);
    addBox(level.mesh, {}, {wall.x0, 0.0, wall.z0}, {wall.x1, clear - 0.4, wall.z1}, level.palette.inner_wall);
    const bool along_x = wall.width() > wall.depth();
    for (const Side side : {along_x ? Side::north : Side::west, along_x ? Side::south : Side::east}) {
      const Rect room = wall.strip(opposite(side), wall.start(side), wall.start(side) + wall.length(side), -1.0);
      hangPanels(level, room, side, 2.4, fittings, 0.3, clear - 0.5);
    }
  }
  // the hall's own, on either side of the ends
  for (const Rect& part : {Rect{in.x0, in.z0, west, in.z1}, Rect{west + thick, in.z0, in.x1, in.z1}})
    hangPanels(level, part, Side::north, 2.8, fittings, 0.25, clear - 0.3);
  for (const Rect& part : {Rect{in.x0, in.z0, east, in.z1}, Rect{east + thick, in.z0, in.x1, in.z1}})
    hangPanels(level, part, Side::south, 2.8, fittings, 0.25, clear - 0.3);
  hangPanels(level, in, Side::west, 2.8, fittings, 0.25, clear - 0.3);
  for (const Side side : {Side::north, Side::south, Side::west}) {
    const double half = 0.5 * in.length(side) - 0.03;
    addPlates(level, "skirting", onWall(in, side, half + 0.03, 0.01, 0.005), {{{-half, 0, 0}, {half, 0.09, 0.015}}},
              level.palette.inner_wall, Plates::boards);
  }
  for (const double z : {in.z0 + 1.2, in.z1 - 1.2}) {
    BrushGrid track;
    track.fill({in.x0 + 0.5, clear - 0.06, z - 0.02}, {in.x1 - 0.5, clear - 0.02, z + 0.02}, level.palette.metal);
    for (double x = in.x0 + 1.0; x < in.x1 - 0.8; x += 1.2)
      track.fill({x, clear - 0.26, z - 0.07}, {x + 0.14, clear - 0.06, z + 0.07},
                 BrushMaterials(level.palette.metal, level.palette.metal, level.palette.lamp));
    track.emitObject(level.mesh, "track", Mobility::movable);
  }
  addPlates(
      level, "bench", {{in.x1 - 2.4, 0.0, in.middle().y}, {}},
      {{{-0.8, 0.42, -0.22}, {0.8, 0.46, 0.22}}, {{-0.7, 0, -0.2}, {-0.66, 0.42, 0.2}}, {{0.66, 0, -0.2}, {0.7, 0.42, 0.2}}},
      level.palette.wood, Plates::boards);
  level.views = {{"hall", {in.x0 + 0.8, 1.6, in.z1 - 0.8}, {in.x1, 1.2, in.z0 + 0.6}},
                 {"wall", {in.x1 - 0.8, 1.6, in.z0 + 0.8}, {in.x0, 1.3, in.z1 - 0.8}},
                 {"panels", {in.middle().x + 1.2, 1.6, in.z1 - 1.6}, {in.middle().x - 1.2, 1.3, in.z1}}};
}

void buildMeeting(Level& level) {
  const Fittings fittings = drawFittings(level);
  Building building = makeRoom(level, {4.6, 2.5, 4.0}, {7.0, 2.9, 5.2}, {Side::north, Side::west});
  const Rect in = building.inner();
  const double clear = building.clear_m[0];
  carveHole(building, 0, Side::south, 0.5, in.width() - 0.5, 0.8, clear - 0.2, 0.0);
  carveDoor(building, Side::east, 0, 0.6, 0.9);
  building.shell.emitObject(level.mesh, "shell", Mobility::structure);
  // a blind of 8 mm slats before the window: sheets far thinner than any probe spacing
  std::vector<Box> slats;
  const double pitch = level.random.uniform(0.08, 0.16);
  for (double y = level.pick(0.9, 1.6); y < clear - 0.15; y += pitch)
    slats.push_back({{0.4, y, 0.05}, {in.width() - 0.4, y + 0.008, 0.1}});
  addPlates(level, "blind", {{in.x1, 0.0, in.z1}, turnByDegrees(180.0)}, slats, fittings.panel, fittings.plates);
  // panels on two walls, a row of units below those of the west
  hangPanels(level, in, Side::north, 1.6, fittings, 0.2, clear - 0.15);
  hangPanels(level, in, Side::west, 2.2, fittings, 0.85, clear - 0.2);
  for (double along = 0.8; along + 0.5 < in.depth(); along += 0.9)
    addUnit(level, onWall(in, Side::west, along, 0.05, 0.03), {0.88, 0.7, 0.42}, fittings, Doors::shut);
  // table and chairs of thin boards
  const double half = 0.5 * std::min(level.pick(1.8, 3.0), in.width() - 2.4), t = 0.5 * kBoard_m;
  const Placement middle{{in.middle().x + 0.3, 0.0, in.middle().y}, {}};
  addPlates(level, "table", middle,
            {{{-half, 0.73, -0.5}, {half, 0.75, 0.5}},
             {{-half + 0.2, 0, -0.4}, {-half + 0.22, 0.73, 0.4}},
             {{half - 0.22, 0, -0.4}, {half - 0.2, 0.73, 0.4}}},
            fittings.front, fittings.plates);
  for (const double side : {-1.0, 1.0}) {
    for (double x = 0.4 - half; x < half - 0.2; x += 0.7) {
      const double turn = (side > 0.0 ? 0.0 : 180.0) + level.random.uniform(-20.0, 20.0);
      addPlates(level, "chair", {middle.apply({x, 0.0, side * 0.75}), turnByDegrees(turn)},
                {{{-0.22, 0.44, -0.22}, {0.22, 0.46, 0.22}},
                 {{-0.22, 0.5, 0.2}, {0.22, 0.92, 0.22}},
                 {{-0.22, 0, -t}, {0.22, 0.44, t}}},
                fittings.carcass, fittings.plates);
    }
  }
  // a sheet 10 cm below the ceiling, and air between both
  addPlates(level, "raft", middle, {{{-half, clear - 0.12, -0.6}, {half, clear - 0.1, 0.6}}}, level.palette.ceiling,
            Plates::boards);
  addLamps(level, building, 2);
  level.views = {{"table", {in.x1 - 0.6, 1.6, in.z1 - 0.6}, {in.x0, 0.9, in.z0 + 0.6}},
                 {"panels", {in.middle().x + 0.5, 1.6, in.z1 - 1.0}, {in.middle().x - 0.8, 1.2, in.z0}},
                 {"window", {in.x1 - 0.7, 1.6, in.z0 + 0.6}, {in.x0 + 0.6, 0.9, in.z1}}};
}

}  // namespace nlg
