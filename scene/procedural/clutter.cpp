// The family "clutter": interiors full of things, as a flat, an office, a warehouse or a workshop.
#include "scene/procedural/building.h"

namespace nlg {
namespace {

enum class Style { flat, office, warehouse, workshop };

// Rows of tall shelves with aisles between them.
void addShelfRows(Level& level, const Room& room) {
  const double depth = level.pick(0.5, 0.9);
  const double aisle = level.pick(1.3, 2.0);
  const double width = level.pick(1.6, 2.4);
  const double height = std::min(level.pick(1.8, 2.8), room.clear_m - 0.5);
  const Rect area = room.floor.grown(-1.4);
  for (double z = area.z0 + 0.5 * depth; z + 0.5 * depth < area.z1; z += depth + aisle) {
    for (double x = area.x0 + 0.5 * width; x + 0.5 * width < area.x1; x += width + 0.05) {
      if (level.random.chance(0.15)) continue;
      addShelf(level, {{x, room.floor_m, z}, turnByDegrees(level.random.chance(0.5) ? 0.0 : 180.0)}, {width, height, depth});
    }
  }
}

// Desks back to back in islands, low screens between them.
void addDesks(Level& level, const Room& room) {
  const Rect area = room.floor.grown(-1.5);
  for (double z = area.z0 + 0.8; z + 0.8 < area.z1; z += 3.4) {
    for (double x = area.x0 + 0.8; x + 0.8 < area.x1; x += 1.75) {
      if (level.random.chance(0.2)) continue;
      for (const double side : {-1.0, 1.0}) {
        const double degrees = side > 0.0 ? 0.0 : 180.0;
        addTable(level, {{x, room.floor_m, z + side * 0.42}, turnByDegrees(degrees)}, {1.6, 0.75, 0.75});
        if (level.random.chance(0.8)) {
          addChair(level, {{x + level.random.uniform(-0.2, 0.2), room.floor_m, z + side * 1.05},
                           turnByDegrees(degrees + 180.0 + level.random.uniform(-30.0, 30.0))});
        }
      }
      level.mesh.beginObject("screen", Mobility::movable);
      addBox(level.mesh, {{x, room.floor_m, z}, {}}, {-0.85, 0, -0.03}, {0.85, 1.25, 0.03}, level.palette.cloth);
    }
  }
}

void addPillars(Level& level, const Building& building) {
  const Rect in = building.inner();
  const double distance = level.pick(3.5, 5.0);
  const double half = level.pick(0.12, 0.25);
  const bool is_round = level.random.chance(0.5);
  for (double x = in.x0 + distance; x < in.x1 - 1.5; x += distance) {
    for (double z = in.z0 + distance; z < in.z1 - 1.5; z += distance) {
      level.mesh.beginObject("pillar", Mobility::structure);
      const double clear = building.clear_m[0];
      addLathe(level.mesh, {{x, building.ground_m, z}, turnByDegrees(45.0)}, {{0, half}, {clear, half}}, is_round ? 10 : 4,
               level.palette.stone);
    }
  }
}

void addPipes(Level& level, const Building& building) {
  const Rect in = building.inner();
  const double ceiling = building.ground_m + building.clear_m[0];
  for (int i = level.pickCount(2, 5); i > 0; --i) {
    const double radius = level.pick(0.05, 0.2);
    const double z = level.random.uniform(in.z0 + 0.4, in.z1 - 0.4);
    const double x = level.random.uniform(in.z0 + 0.4, in.z1 - 0.4);
    const double y = ceiling - radius - level.pick(0.15, 0.5);
    if (level.random.chance(0.5))
      addPipe(level, {{in.x0, y, z}, {}}, in.width(), radius);
    else if (x > in.x0 + 0.4 && x < in.x1 - 0.4)
      addPipe(level, {{x, y, in.z1}, turnByDegrees(90.0)}, in.depth(), radius);
  }
}

// A room on the roof's underside: a gallery along one wall, as warehouses have.
void addGallery(Level& level, const Building& building) {
  const Rect in = building.inner();
  const double floor = 2.3;
  const double reach = level.pick(1.5, 2.5);
  BrushGrid grid;
  grid.fill({in.x0 + 0.02, floor, in.z0 + 0.02}, {in.x1 - 0.02, floor + 0.15, in.z0 + reach}, level.palette.metal);
  for (double x = in.x0 + 0.3; x < in.x1 - 0.3; x += 3.0) {
    grid.fill({x, 0, in.z0 + reach - 0.2}, {x + 0.12, floor, in.z0 + reach - 0.08}, level.palette.metal);
  }
  grid.emitObject(level.mesh, "gallery", Mobility::structure);
  addRailing(level, {{in.x0 + 1.4, floor + 0.15, in.z0 + reach - 0.06}, {}}, in.width() - 1.5);
}

void furnish(Level& level, Room& room, Style style) {
  const bool is_large = room.floor.width() > 5.5 && room.floor.depth() > 5.0;
  if (style == Style::warehouse && is_large) addShelfRows(level, room);
  if (style == Style::office && is_large) addDesks(level, room);
  if (is_large && (style == Style::warehouse || style == Style::office)) room.keep_free.push_back(room.floor.grown(-1.3));
  const RoomUse homely[] = {RoomUse::living, RoomUse::bedroom, RoomUse::study};
  const RoomUse use = style == Style::flat        ? homely[level.random.below(3)]
                      : style == Style::office    ? RoomUse::study
                      : style == Style::warehouse ? RoomUse::store
                                                  : RoomUse::workshop;
  furnishRoom(level, room, use, level.random.uniform(0.8, 1.3));
}

}  // namespace

void buildClutter(Level& level) {
  // warehouse and workshop are high, with gates instead of doors
  const Style style = static_cast<Style>(level.pickCount(0, 3));
  const bool is_tall = style == Style::warehouse || style == Style::workshop;
  Building building;
  const double width = level.pick(10.0, 16.0);
  const double depth = level.pick(8.0, 13.0);
  building.outer = {-0.5 * width, -0.5 * depth, 0.5 * width, 0.5 * depth};
  building.wall_m = level.pick(0.2, 0.35);
  building.clear_m = {is_tall ? level.pick(3.8, 5.2) : level.pick(2.6, 3.2)};
  addGround(level, building, 2.0);
  fillShell(level, building);
  carveWindows(level, building, 0, is_tall ? 0.35 : 0.7);
  carveDoor(building, Side::south, 0, level.random.uniform(0.5, depth - 2.0), is_tall ? 2.4 : 1.0, is_tall ? 2.6 : 2.05);
  if (level.random.chance(0.5)) carveDoor(building, Side::east, 0, level.random.uniform(0.5, depth - 2.0), 0.9);
  building.shell.emitObject(level.mesh, "shell", Mobility::structure);

  // halls stay whole or in few rooms, offices keep some large ones, the others part down to small rooms
  PlanOptions options;
  options.min_side_m = is_tall ? 4.0 : level.pick(2.8, 3.6);
  options.stop_chance = is_tall ? 0.8 : style == Style::office ? 0.5 : 0.15;
  const Rect area = building.inner();
  std::vector<Room> rooms = is_tall && level.random.chance(0.6)
                                ? std::vector<Room>{{area, building.ground_m, building.clear_m[0], building.openingsOf(0)}}
                                : partStorey(level, building, 0, area, options, {});
  for (Room& room : rooms) furnish(level, room, style);
  // what fills the height of a hall: pillars, pipes, a gallery
  if (is_tall) addPillars(level, building);
  if (is_tall || level.random.chance(0.4)) addPipes(level, building);
  if (style == Style::warehouse && rooms.size() == 1) addGallery(level, building);
}

}  // namespace nlg
