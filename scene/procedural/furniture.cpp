#include "scene/procedural/furniture.h"

#include <algorithm>

namespace nlg {
namespace {

constexpr double kLeg = 0.07;

// Four legs under a rectangle around the origin.
void fillLegs(BrushGrid& grid, double width, double depth, double height, uint32_t material) {
  for (const double x : {-0.5 * width, 0.5 * width - kLeg}) {
    for (const double z : {-0.5 * depth, 0.5 * depth - kLeg}) grid.fill({x, 0, z}, {x + kLeg, height, z + kLeg}, material);
  }
}

Placement at(double x, double y, double z, double degrees) { return {{x, y, z}, turnByDegrees(degrees)}; }

// Metres; a range of one number is not drawn.
struct Range {
  double low, high;
};

// What furniture of a kind may measure, and what makes it.
struct Kind {
  Range width, height, depth;
  void (*add)(Level&, const Placement&, const glm::dvec3& size_m);
};

struct Item {
  const Kind* kind;
  glm::dvec3 size_m;
};

void addCrateOf(Level& level, const Placement& at, const glm::dvec3& size_m) { addCrate(level, at, size_m.y); }
void addCratePileOf(Level& level, const Placement& at, const glm::dvec3&) { addCratePile(level, at, level.pickCount(2, 4)); }
void addBarrelOf(Level& level, const Placement& at, const glm::dvec3& size_m) { addBarrel(level, at, size_m.y); }

constexpr Kind kTable = {{1.0, 1.8}, {0.7, 0.8}, {0.6, 0.8}, addTable};
constexpr Kind kBed = {{0.9, 1.8}, {1.0, 1.0}, {1.95, 2.15}, addBed};
constexpr Kind kSofa = {{1.4, 2.4}, {0.85, 0.85}, {0.8, 0.95}, addSofa};
constexpr Kind kShelf = {{0.8, 2.0}, {1.2, 2.2}, {0.3, 0.5}, addShelf};
constexpr Kind kCupboard = {{0.8, 1.6}, {0.9, 2.1}, {0.5, 0.65}, addCupboard};
constexpr Kind kCrate = {{0.9, 0.9}, {0.5, 0.85}, {0.9, 0.9}, addCrateOf};
constexpr Kind kCratePile = {{1.9, 1.9}, {1.7, 1.7}, {1.0, 1.0}, addCratePileOf};
constexpr Kind kBarrel = {{0.75, 0.75}, {0.8, 1.1}, {0.75, 0.75}, addBarrelOf};
constexpr Kind kMachine = {{1.2, 2.2}, {1.2, 1.9}, {0.9, 1.4}, addMachine};

Item drawItem(Level& level, RoomUse use) {
  // by use; what stands twice is drawn twice as often
  static const std::vector<const Kind*> kinds_of[] = {{&kSofa, &kShelf, &kCupboard, &kTable, &kSofa},
                                                      {&kBed, &kCupboard, &kShelf, &kBed, &kTable},
                                                      {&kShelf, &kShelf, &kTable, &kCupboard, &kCrate},
                                                      {&kCratePile, &kCrate, &kBarrel, &kShelf, &kCratePile, &kBarrel},
                                                      {&kMachine, &kTable, &kBarrel, &kCratePile, &kShelf, &kMachine}};
  const std::vector<const Kind*>& kinds = kinds_of[static_cast<size_t>(use)];
  const Kind* kind = kinds[level.random.below(static_cast<uint32_t>(kinds.size()))];
  const auto draw = [&](const Range& range) { return range.low < range.high ? level.pick(range.low, range.high) : range.low; };
  const double width = draw(kind->width), depth = draw(kind->depth), height = draw(kind->height);
  return {kind, {width, height, depth}};
}

// Where an item stands with its back to one of the room's walls.
struct Spot {
  Rect area;
  double degrees;
};

Spot drawWallSpot(Level& level, const Rect& floor, const Item& item) {
  constexpr double kGap = 0.03;  // to the wall: skirting, and no coplanar faces
  const Side wall = kSides[level.pickCount(0, 3)];
  const double start = kGap + level.random.uniform() * std::max(0.0, floor.length(wall) - item.size_m.x - 2 * kGap);
  const double first = floor.start(wall);
  return {floor.strip(wall, first + start, first + (start + item.size_m.x), item.size_m.z + kGap, kGap), degreesAt(wall)};
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

void addBed(Level& level, const Placement& placement, const glm::dvec3& size_m) {
  const double width = size_m.x, length = size_m.z;
  const Palette& palette = level.palette;
  BrushGrid grid;
  fillLegs(grid, width, length, 0.25, palette.dark_wood);
  grid.fill({-0.5 * width, 0.2, -0.5 * length}, {0.5 * width, 0.32, 0.5 * length}, palette.dark_wood);
  grid.fill({-0.5 * width, 0.2, -0.5 * length}, {0.5 * width, level.pick(0.8, 1.1), -0.5 * length + 0.07}, palette.dark_wood);
  grid.fill({-0.5 * width + 0.05, 0.32, -0.5 * length + 0.07}, {0.5 * width - 0.05, 0.5, 0.5 * length - 0.05}, palette.cloth);
  grid.fill({-0.4 * width, 0.5, -0.5 * length + 0.1}, {0.4 * width, 0.6, -0.5 * length + 0.5}, palette.ceiling);
  grid.emitObject(level.mesh, "bed", Mobility::movable, placement);
}

void addSofa(Level& level, const Placement& placement, const glm::dvec3& size_m) {
  const double x = 0.5 * size_m.x, z = 0.5 * size_m.z;
  BrushGrid grid;
  fillLegs(grid, size_m.x, size_m.z, 0.12, level.palette.dark_wood);
  grid.fill({-x, 0.1, -z}, {x, 0.42, z}, level.palette.cloth);
  grid.fill({-x, 0.1, -z}, {x, 0.85, -z + 0.2}, level.palette.cloth);
  grid.fill({-x, 0.1, -z}, {-x + 0.18, 0.62, z}, level.palette.cloth);
  grid.fill({x - 0.18, 0.1, -z}, {x, 0.62, z}, level.palette.cloth);
  grid.emitObject(level.mesh, "sofa", Mobility::movable, placement);
}

void addCupboard(Level& level, const Placement& placement, const glm::dvec3& size_m) {
  const double x = 0.5 * size_m.x, z = 0.5 * size_m.z, height = size_m.y;
  BrushGrid grid;
  grid.fill({-x + 0.05, 0, -z}, {x - 0.05, 0.1, z - 0.05}, level.palette.dark_wood);
  grid.fill({-x, 0.1, -z}, {x, height, z}, level.palette.wood);
  grid.carve({-0.02, 0.15, z - 0.05}, {0.02, height - 0.1, z});
  grid.emitObject(level.mesh, "cupboard", Mobility::movable, placement);
}

void addMachine(Level& level, const Placement& placement, const glm::dvec3& size_m) {
  const double x = 0.5 * size_m.x, z = 0.5 * size_m.z, height = size_m.y;
  BrushGrid grid;
  grid.fill({-x, 0, -z}, {x, 0.15, z}, level.palette.dark_wood);
  grid.fill({-x + 0.1, 0.15, -z}, {x - 0.1, height, z - 0.15}, level.palette.metal);
  grid.fill({-x + 0.1, 0.15, -z}, {x - 0.1, 0.6 * height, z}, level.palette.metal);
  grid.carve({-x + 0.25, 0.35 * height, z - 0.4}, {0.1 * x, 0.5 * height, z});
  grid.emitObject(level.mesh, "machine", Mobility::movable, placement);
  const double pipe_radius = level.pick(0.1, 0.2);
  Placement chimney = placement;
  chimney.position = placement.apply({0.3 * size_m.x, height, -0.2 * size_m.z});
  addLathe(level.mesh, chimney, {{-0.05, pipe_radius}, {0.6, pipe_radius}}, 8, level.palette.metal);
}

void addDiningGroup(Level& level, const Placement& placement, double width, double depth) {
  addTable(level, placement, {width, level.pick(0.7, 0.8), depth});
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

void addTable(Level& level, const Placement& placement, const glm::dvec3& size_m) {
  const double x = 0.5 * size_m.x, z = 0.5 * size_m.z, height = size_m.y;
  BrushGrid grid;
  fillLegs(grid, size_m.x - 0.1, size_m.z - 0.1, height, level.palette.wood);
  grid.fill({-x, height - 0.06, -z}, {x, height, z}, level.palette.wood);
  grid.emitObject(level.mesh, "table", Mobility::movable, placement);
}

void addChair(Level& level, const Placement& placement) {
  BrushGrid grid;
  fillLegs(grid, 0.42, 0.42, 0.45, level.palette.dark_wood);
  grid.fill({-0.22, 0.42, -0.22}, {0.22, 0.48, 0.22}, level.palette.dark_wood);
  grid.fill({-0.21, 0.48, -0.21}, {0.21, 0.95, -0.15}, level.palette.dark_wood);
  grid.carve({-0.14, 0.55, -0.21}, {0.14, 0.78, -0.15});
  grid.emitObject(level.mesh, "chair", Mobility::movable, placement);
}

void addShelf(Level& level, const Placement& placement, const glm::dvec3& size_m) {
  const Palette& palette = level.palette;
  const double x = 0.5 * size_m.x, z = 0.5 * size_m.z, height = size_m.y;
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
    const double to = std::min(x - 0.1, from + level.random.uniform(0.2, size_m.x));
    const double block_height = 0.6 * (height - 0.1) / board_count;
    grid.fill({from, y + 0.05, -z + 0.05}, {to, y + 0.05 + block_height, z - 0.06}, palette.cloth);
  }
  grid.emitObject(level.mesh, "shelf", Mobility::movable, placement);
}

void addCrate(Level& level, const Placement& placement, double side_m) {
  const double half = 0.5 * side_m;
  BrushGrid grid;
  grid.fill({-half, 0, -half}, {half, side_m, half}, level.palette.wood);
  if (level.random.chance(0.3)) grid.carve({-half + 0.06, 0.1, -half + 0.06}, {half - 0.06, side_m, half - 0.06});
  grid.emitObject(level.mesh, "crate", Mobility::movable, placement);
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
  const int side_count = level.pickCount(8, 12);
  addLathe(level.mesh, placement, {{0, 0.85 * radius}, {0.5 * height, radius}, {height, 0.85 * radius}}, side_count,
           level.random.chance(0.5) ? level.palette.metal : level.palette.wood);
}

void addCeilingLamp(Level& level, const Placement& placement) {
  BrushGrid grid;
  const double drop = level.pick(0.1, 0.6);
  grid.fill({-0.03, -drop, -0.03}, {0.03, 0, 0.03}, level.palette.metal);
  const glm::dvec2 half{level.pick(0.15, 0.6), level.pick(0.15, 0.25)};
  grid.fill({-half.x, -drop - 0.08, -half.y}, {half.x, -drop, half.y},
            BrushMaterials(level.palette.metal, level.palette.metal, level.palette.lamp));
  grid.emitObject(level.mesh, "lamp", Mobility::movable, placement);
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

void addTree(Level& level, const glm::dvec3& foot) {
  const double height = level.pick(2.0, 4.0);
  const double radius = level.pick(0.12, 0.25);
  level.mesh.beginObject("trunk", Mobility::movable);
  addLathe(level.mesh, {{foot.x, foot.y - 0.3, foot.z}, {}}, {{0, 1.4 * radius}, {0.6, radius}, {height, 0.6 * radius}}, 7,
           level.palette.dark_wood);
  const double crown = level.pick(0.8, 1.6);
  level.mesh.beginObject("crown", Mobility::movable);
  addRock(level.mesh, {{foot.x, foot.y + height + 0.3 * crown, foot.z}, {}}, {crown, 0.9 * crown, crown}, level.random.next(),
          level.palette.leaf);
}

void furnishRoom(Level& level, const Room& room, RoomUse use, double density) {
  std::vector<Rect> taken = room.keep_free;
  if (level.random.chance(0.3 + 0.6 * density)) furnishMiddle(level, room, use, taken);
  const int try_count = static_cast<int>(2.0 * density * (room.floor.width() + room.floor.depth()));
  for (int i = 0; i < try_count; ++i) {
    Item item = drawItem(level, use);
    item.size_m.y = std::min(item.size_m.y, room.clear_m - 0.4);
    const Spot spot = drawWallSpot(level, room.floor, item);
    const bool fits = spot.area.x0 >= room.floor.x0 && spot.area.x1 <= room.floor.x1 && spot.area.z0 >= room.floor.z0 &&
                      spot.area.z1 <= room.floor.z1;
    if (!fits || !isFree(spot.area, taken)) continue;
    taken.push_back(spot.area.grown(0.1));
    const glm::dvec2 middle = spot.area.middle();
    item.kind->add(level, at(middle.x, room.floor_m, middle.y, spot.degrees), item.size_m);
  }
  if (level.random.chance(0.8)) {
    const glm::dvec2 middle = room.floor.middle();
    addCeilingLamp(level, at(middle.x, room.floor_m + room.clear_m, middle.y, level.random.chance(0.5) ? 90.0 : 0.0));
  }
}

}  // namespace nlg
