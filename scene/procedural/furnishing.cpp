#include "scene/procedural/furnishing.h"

#include <algorithm>

#include "scene/procedural/furniture.h"

namespace nlg {
namespace {

Placement at(double x, double y, double z, double degrees) { return {{x, y, z}, turnByDegrees(degrees)}; }

// Metres; a range of one number is not drawn.
struct Range {
  double low, high;
};

struct Item;

// What furniture of a kind may measure, and what makes it.
struct Kind {
  Range width, depth, height;
  void (*add)(Level&, const Placement&, const Item&);
};

struct Item {
  const Kind* kind;
  double width, depth, height;
};

using At = Placement;
constexpr Kind kTable = {{1.0, 1.8},
                         {0.6, 0.8},
                         {0.7, 0.8},
                         [](Level&level, const At&at, const Item&i) { addTable(level, at, i.width, i.depth, i.height); }},
               kBed = {{0.9, 1.8},
                       {1.95, 2.15},
                       {1.0, 1.0},
                       [](Level&level, const At&at, const Item&i) { addBed(level, at, i.width, i.depth); }},
               kSofa = {{1.4, 2.4},
                        {0.8, 0.95},
                        {0.85, 0.85},
                        [](Level&level, const At&at, const Item&i) { addSofa(level, at, i.width, i.depth); }},
               kShelf = {{0.8, 2.0},
                         {0.3, 0.5},
                         {1.2, 2.2},
                         [](Level&level, const At&at, const Item&i) { addShelf(level, at, i.width, i.depth, i.height); }},
               kCupboard = {{0.8, 1.6},
                            {0.5, 0.65},
                            {0.9, 2.1},
                            [](Level&level, const At&at, const Item&i) { addCupboard(level, at, i.width, i.depth, i.height); }},
               kCrate = {{0.9, 0.9},
                         {0.9, 0.9},
                         {0.5, 0.85},
                         [](Level&level, const At&at, const Item&i) { addCrate(level, at, i.height); }},
               kCratePile = {{1.9, 1.9},
                             {1.0, 1.0},
                             {1.7, 1.7},
                             [](Level&level, const At&at, const Item&) { addCratePile(level, at, level.pickCount(2, 4)); }},
               kBarrel = {{0.75, 0.75},
                          {0.75, 0.75},
                          {0.8, 1.1},
                          [](Level&level, const At&at, const Item&i) { addBarrel(level, at, i.height); }},
               kMachine = {{1.2, 2.2}, {0.9, 1.4}, {1.2, 1.9}, [](Level&level, const At&at, const Item&i) {
                             addMachine(level, at, i.width, i.depth, i.height);
                           }};

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
  return {kind, draw(kind->width), draw(kind->depth), draw(kind->height)};
}

// Where an item stands with its back to one of the room's walls.
struct Spot {
  Rect area;
  double degrees;
};

Spot drawWallSpot(Level& level, const Rect& floor, const Item& item) {
  constexpr double kGap = 0.03;  // to the wall: skirting, and no coplanar faces
  const Side wall = kSides[level.pickCount(0, 3)];
  const double start = kGap + level.random.uniform() * std::max(0.0, floor.length(wall) - item.width - 2 * kGap);
  const double first = floor.start(wall);
  return {floor.strip(wall, first + start, first + (start + item.width), item.depth + kGap, kGap), degreesAt(wall)};
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
    item.kind->add(level, at(middle.x, room.floor_m, middle.y, spot.degrees), item);
  }
  if (level.random.chance(0.8)) {
    const glm::dvec2 middle = room.floor.middle();
    addCeilingLamp(level, at(middle.x, room.floor_m + room.clear_m, middle.y, level.random.chance(0.5) ? 90.0 : 0.0));
  }
}

}  // namespace nlg
