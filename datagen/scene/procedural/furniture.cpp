#include "datagen/scene/procedural/furniture.h"

#include <algorithm>

namespace nlg {
namespace {

constexpr double kLeg = 0.07;

Placement at(double x, double y, double z, double degrees) { return {{x, y, z}, turnByDegrees(degrees)}; }

// Four legs under a rectangle around the origin.
void fillLegs(BrushGrid& grid, double width, double depth, double height, uint32_t material) {
  for (const double x : {-0.5 * width, 0.5 * width - kLeg}) {
    for (const double z : {-0.5 * depth, 0.5 * depth - kLeg}) grid.fill({x, 0, z}, {x + kLeg, height, z + kLeg}, material);
  }
}

void addBed(Level& level, const Placement& placement, double width, double length) {
  const Palette& palette = level.palette;
  level.mesh.beginObject("bed", Mobility::movable);
  BrushGrid grid;
  fillLegs(grid, width, length, 0.25, palette.dark_wood);
  grid.fill({-0.5 * width, 0.2, -0.5 * length}, {0.5 * width, 0.32, 0.5 * length}, palette.dark_wood);
  grid.fill({-0.5 * width, 0.2, -0.5 * length}, {0.5 * width, level.pick(0.8, 1.1), -0.5 * length + 0.07}, palette.dark_wood);
  grid.fill({-0.5 * width + 0.05, 0.32, -0.5 * length + 0.07}, {0.5 * width - 0.05, 0.5, 0.5 * length - 0.05}, palette.cloth);
  grid.fill({-0.4 * width, 0.5, -0.5 * length + 0.1}, {0.4 * width, 0.6, -0.5 * length + 0.5}, palette.ceiling);
  grid.emit(level.mesh, placement);
}

void addSofa(Level& level, const Placement& placement, double width, double depth) {
  level.mesh.beginObject("sofa", Mobility::movable);
  const double x = 0.5 * width;
  const double z = 0.5 * depth;
  BrushGrid grid;
  fillLegs(grid, width, depth, 0.12, level.palette.dark_wood);
  grid.fill({-x, 0.1, -z}, {x, 0.42, z}, level.palette.cloth);
  grid.fill({-x, 0.1, -z}, {x, 0.85, -z + 0.2}, level.palette.cloth);
  grid.fill({-x, 0.1, -z}, {-x + 0.18, 0.62, z}, level.palette.cloth);
  grid.fill({x - 0.18, 0.1, -z}, {x, 0.62, z}, level.palette.cloth);
  grid.emit(level.mesh, placement);
}

void addCupboard(Level& level, const Placement& placement, double width, double depth, double height) {
  level.mesh.beginObject("cupboard", Mobility::movable);
  const double x = 0.5 * width;
  const double z = 0.5 * depth;
  BrushGrid grid;
  grid.fill({-x + 0.05, 0, -z}, {x - 0.05, 0.1, z - 0.05}, level.palette.dark_wood);
  grid.fill({-x, 0.1, -z}, {x, height, z}, level.palette.wood);
  grid.carve({-0.02, 0.15, z - 0.05}, {0.02, height - 0.1, z});
  grid.emit(level.mesh, placement);
}

void addMachine(Level& level, const Placement& placement, double width, double depth, double height) {
  level.mesh.beginObject("machine", Mobility::movable);
  const double x = 0.5 * width;
  const double z = 0.5 * depth;
  BrushGrid grid;
  grid.fill({-x, 0, -z}, {x, 0.15, z}, level.palette.dark_wood);
  grid.fill({-x + 0.1, 0.15, -z}, {x - 0.1, height, z - 0.15}, level.palette.metal);
  grid.fill({-x + 0.1, 0.15, -z}, {x - 0.1, 0.6 * height, z}, level.palette.metal);
  grid.carve({-x + 0.25, 0.35 * height, z - 0.4}, {0.1 * x, 0.5 * height, z});
  grid.emit(level.mesh, placement);
  const double pipe_radius = level.pick(0.1, 0.2);
  Placement chimney = placement;
  chimney.position = placement.apply({0.3 * width, height, -0.2 * depth});
  addLathe(level.mesh, chimney, {{-0.05, pipe_radius}, {0.6, pipe_radius}}, 8, level.palette.metal);
}

// A table with chairs around it, all facing it.
void addDiningGroup(Level& level, const Placement& placement, double width, double depth) {
  addTable(level, placement, width, depth, level.pick(0.7, 0.8));
  for (const double side : {-1.0, 1.0}) {
    const int chair_count = std::max(1, static_cast<int>(width / 0.75));
    for (int i = 0; i < chair_count; ++i) {
      if (level.random.chance(0.15)) continue;
      const double x = width * ((i + 0.5) / chair_count - 0.5);
      Placement chair = placement;
      chair.position = placement.apply({x, 0, side * (0.5 * depth + 0.2)});
      const Turn facing = turnByDegrees(side > 0 ? 180.0 : 0.0);
      const Turn& t = placement.turn;
      chair.turn = {t.cosine * facing.cosine - t.sine * facing.sine, t.sine * facing.cosine + t.cosine * facing.sine};
      addChair(level, chair);
    }
  }
}

enum class Kind { table, bed, sofa, shelf, cupboard, crate, crate_pile, barrel, machine };

struct Item {
  Kind kind;
  double width, depth, height;
};

Item drawItem(Level& level, RoomUse use) {
  static const std::vector<Kind> living = {Kind::sofa, Kind::shelf, Kind::cupboard, Kind::table, Kind::sofa};
  static const std::vector<Kind> bedroom = {Kind::bed, Kind::cupboard, Kind::shelf, Kind::bed, Kind::table};
  static const std::vector<Kind> study = {Kind::shelf, Kind::shelf, Kind::table, Kind::cupboard, Kind::crate};
  static const std::vector<Kind> store = {Kind::crate_pile, Kind::crate, Kind::barrel, Kind::shelf, Kind::crate_pile, Kind::barrel};
  static const std::vector<Kind> workshop = {Kind::machine, Kind::table, Kind::barrel, Kind::crate_pile, Kind::shelf, Kind::machine};
  const auto& kinds = use == RoomUse::living    ? living
                      : use == RoomUse::bedroom ? bedroom
                      : use == RoomUse::study   ? study
                      : use == RoomUse::store   ? store
                                                : workshop;
  switch (const Kind kind = kinds[level.random.below(static_cast<uint32_t>(kinds.size()))]) {
    case Kind::table: return {kind, level.pick(1.0, 1.8), level.pick(0.6, 0.8), level.pick(0.7, 0.8)};
    case Kind::bed: return {kind, level.pick(0.9, 1.8), level.pick(1.95, 2.15), 1.0};
    case Kind::sofa: return {kind, level.pick(1.4, 2.4), level.pick(0.8, 0.95), 0.85};
    case Kind::shelf: return {kind, level.pick(0.8, 2.0), level.pick(0.3, 0.5), level.pick(1.2, 2.2)};
    case Kind::cupboard: return {kind, level.pick(0.8, 1.6), level.pick(0.5, 0.65), level.pick(0.9, 2.1)};
    case Kind::crate: return {kind, 0.9, 0.9, level.pick(0.5, 0.85)};
    case Kind::crate_pile: return {kind, 1.9, 1.0, 1.7};
    case Kind::barrel: return {kind, 0.75, 0.75, level.pick(0.8, 1.1)};
    case Kind::machine: return {kind, level.pick(1.2, 2.2), level.pick(0.9, 1.4), level.pick(1.2, 1.9)};
  }
  return {Kind::crate, 0.9, 0.9, 0.7};
}

void addItem(Level& level, const Placement& placement, const Item& item) {
  switch (item.kind) {
    case Kind::table: addTable(level, placement, item.width, item.depth, item.height); break;
    case Kind::bed: addBed(level, placement, item.width, item.depth); break;
    case Kind::sofa: addSofa(level, placement, item.width, item.depth); break;
    case Kind::shelf: addShelf(level, placement, item.width, item.depth, item.height); break;
    case Kind::cupboard: addCupboard(level, placement, item.width, item.depth, item.height); break;
    case Kind::crate: addCrate(level, placement, item.height); break;
    case Kind::crate_pile: addCratePile(level, placement, level.pickCount(2, 4)); break;
    case Kind::barrel: addBarrel(level, placement, item.height); break;
    case Kind::machine: addMachine(level, placement, item.width, item.depth, item.height); break;
  }
}

// Where an item stands with its back to one of the room's walls.
struct Spot {
  Rect area;
  double degrees;
};

Spot drawWallSpot(Level& level, const Rect& floor, const Item& item) {
  constexpr double kGap = 0.03;  // to the wall: skirting, and no coplanar faces
  const int wall = level.pickCount(0, 3);
  const bool along_x = wall % 2 == 0;
  const double length = along_x ? floor.width() : floor.depth();
  const double start = kGap + level.random.uniform() * std::max(0.0, length - item.width - 2 * kGap);
  const double end = start + item.width;
  const double reach = item.depth + kGap;
  switch (wall) {
    case 0: return {{floor.x0 + start, floor.z0 + kGap, floor.x0 + end, floor.z0 + reach}, 0.0};
    case 1: return {{floor.x0 + kGap, floor.z0 + start, floor.x0 + reach, floor.z0 + end}, 90.0};
    case 2: return {{floor.x0 + start, floor.z1 - reach, floor.x0 + end, floor.z1 - kGap}, 180.0};
    default: return {{floor.x1 - reach, floor.z0 + start, floor.x1 - kGap, floor.z0 + end}, 270.0};
  }
}

bool isFree(const Rect& area, const std::vector<Rect>& taken) {
  return std::none_of(taken.begin(), taken.end(), [&](const Rect& other) { return area.overlaps(other); });
}

void furnishMiddle(Level& level, const Room& room, RoomUse use, std::vector<Rect>& taken) {
  const double width = std::min(level.pick(1.4, 2.4), room.floor.width() - 2.4);
  const double depth = level.pick(0.8, 1.0);
  if (width < 1.0 || room.floor.depth() < depth + 2.8) return;
  const glm::dvec2 middle = room.floor.middle();
  const Rect area{middle.x - 0.5 * width, middle.y - 0.5 * depth - 0.5, middle.x + 0.5 * width, middle.y + 0.5 * depth + 0.5};
  if (!isFree(area, taken)) return;
  taken.push_back(area.grown(0.4));
  const Placement placement = at(middle.x, room.floor_m, middle.y, 0.0);
  if (use == RoomUse::store || use == RoomUse::workshop) {
    addCratePile(level, placement, level.pickCount(3, 5));
  } else {
    addDiningGroup(level, placement, width, depth);
  }
}

}  // namespace

void addTable(Level& level, const Placement& placement, double width, double depth, double height) {
  level.mesh.beginObject("table", Mobility::movable);
  BrushGrid grid;
  fillLegs(grid, width - 0.1, depth - 0.1, height, level.palette.wood);
  grid.fill({-0.5 * width, height - 0.06, -0.5 * depth}, {0.5 * width, height, 0.5 * depth}, level.palette.wood);
  grid.emit(level.mesh, placement);
}

void addChair(Level& level, const Placement& placement) {
  level.mesh.beginObject("chair", Mobility::movable);
  BrushGrid grid;
  fillLegs(grid, 0.42, 0.42, 0.45, level.palette.dark_wood);
  grid.fill({-0.22, 0.42, -0.22}, {0.22, 0.48, 0.22}, level.palette.dark_wood);
  grid.fill({-0.21, 0.48, -0.21}, {0.21, 0.95, -0.15}, level.palette.dark_wood);
  grid.carve({-0.14, 0.55, -0.21}, {0.14, 0.78, -0.15});
  grid.emit(level.mesh, placement);
}

void addShelf(Level& level, const Placement& placement, double width, double depth, double height) {
  const Palette& palette = level.palette;
  level.mesh.beginObject("shelf", Mobility::movable);
  const double x = 0.5 * width;
  const double z = 0.5 * depth;
  const int board_count = std::max(2, static_cast<int>(height / 0.42));
  BrushGrid grid;
  grid.fill({-x, 0, -z}, {-x + 0.05, height, z}, palette.wood);
  grid.fill({x - 0.05, 0, -z}, {x, height, z}, palette.wood);
  if (level.random.chance(0.6)) grid.fill({-x, 0, -z}, {x, height, -z + 0.05}, palette.wood);
  for (int board = 0; board <= board_count; ++board) {
    const double y = 0.05 + (height - 0.1) * board / board_count;
    grid.fill({-x, y, -z}, {x, y + 0.05, z}, palette.wood);
    if (board == board_count || level.random.chance(0.3)) continue;
    // one block of books or boxes a board: what casts shadows, not what is read
    const double from = level.random.uniform(-x + 0.1, 0.0);
    const double to = std::min(x - 0.1, from + level.random.uniform(0.2, width));
    const double block_height = 0.6 * (height - 0.1) / board_count;
    grid.fill({from, y + 0.05, -z + 0.05}, {to, y + 0.05 + block_height, z - 0.06}, palette.cloth);
  }
  grid.emit(level.mesh, placement);
}

void addCrate(Level& level, const Placement& placement, double side_m) {
  level.mesh.beginObject("crate", Mobility::movable);
  const double half = 0.5 * side_m;
  BrushGrid grid;
  grid.fill({-half, 0, -half}, {half, side_m, half}, level.palette.wood);
  if (level.random.chance(0.3)) grid.carve({-half + 0.06, 0.1, -half + 0.06}, {half - 0.06, side_m, half - 0.06});
  grid.emit(level.mesh, placement);
}

void addCratePile(Level& level, const Placement& placement, int count) {
  double x = -0.5 * count * 0.5;
  double stack_m = 0.0;
  for (int i = 0; i < count; ++i) {
    const double side = level.pick(0.5, 0.85);
    const bool on_top = stack_m > 0.0 && stack_m < 1.2 && level.random.chance(0.5);
    if (!on_top) {
      x += 0.95;
      stack_m = 0.0;
    }
    Placement crate = placement;
    crate.position = placement.apply({x - 0.95, stack_m, level.random.uniform(-0.1, 0.1)});
    crate.turn = turnByDegrees(level.random.uniform(-25.0, 25.0));
    addCrate(level, crate, side);
    stack_m += side;
  }
}

void addBarrel(Level& level, const Placement& placement, double height) {
  level.mesh.beginObject("barrel", Mobility::movable);
  const double radius = level.pick(0.25, 0.35);
  addLathe(level.mesh, placement, {{0, 0.85 * radius}, {0.5 * height, radius}, {height, 0.85 * radius}}, level.pickCount(8, 12),
           level.random.chance(0.5) ? level.palette.metal : level.palette.wood);
}

void addCeilingLamp(Level& level, const Placement& placement) {
  level.mesh.beginObject("lamp", Mobility::movable);
  BrushGrid grid;
  const double drop = level.pick(0.1, 0.6);
  grid.fill({-0.03, -drop, -0.03}, {0.03, 0, 0.03}, level.palette.metal);
  const glm::dvec2 half(level.pick(0.15, 0.6), level.pick(0.15, 0.25));
  grid.fill({-half.x, -drop - 0.08, -half.y}, {half.x, -drop, half.y},
            BrushMaterials(level.palette.metal, level.palette.metal, level.palette.lamp));
  grid.emit(level.mesh, placement);
}

void addPipe(Level& level, const Placement& placement, double length, double radius) {
  level.mesh.beginObject("pipe", Mobility::movable);
  std::vector<Ring> rings = {{0, radius}};
  const int clamp_count = static_cast<int>(length / 2.5);
  for (int i = 1; i <= clamp_count; ++i) {
    const double y = length * i / (clamp_count + 1.0);
    for (const Ring& ring : {Ring{y - 0.06, radius}, {y - 0.06, 1.35 * radius}, {y + 0.06, 1.35 * radius}, {y + 0.06, radius}}) {
      rings.push_back(ring);
    }
  }
  rings.push_back({length, radius});
  Placement laid = placement;
  laid.axis = Axis::along_x;
  addLathe(level.mesh, laid, rings, 8, level.palette.metal);
}

void furnishRoom(Level& level, const Room& room, RoomUse use, double density) {
  std::vector<Rect> taken = room.keep_free;
  if (level.random.chance(0.3 + 0.6 * density)) furnishMiddle(level, room, use, taken);
  const int try_count = static_cast<int>(2.0 * density * (room.floor.width() + room.floor.depth()));
  for (int i = 0; i < try_count; ++i) {
    Item item = drawItem(level, use);
    item.height = std::min(item.height, room.clear_m - 0.4);
    const Spot spot = drawWallSpot(level, room.floor, item);
    const bool fits = spot.area.x0 >= room.floor.x0 && spot.area.x1 <= room.floor.x1 && spot.area.z0 >= room.floor.z0 &&
                      spot.area.z1 <= room.floor.z1;
    if (!fits || !isFree(spot.area, taken)) continue;
    taken.push_back(spot.area.grown(0.1));
    const glm::dvec2 middle = spot.area.middle();
    addItem(level, at(middle.x, room.floor_m, middle.y, spot.degrees), item);
  }
  if (level.random.chance(0.8)) {
    const glm::dvec2 middle = room.floor.middle();
    addCeilingLamp(level, at(middle.x, room.floor_m + room.clear_m, middle.y, level.random.chance(0.5) ? 90.0 : 0.0));
  }
}

}  // namespace nlg
