#include "scene/procedural/furnishing.h"

#include <algorithm>

#include "scene/procedural/furniture.h"

namespace nlg {
namespace {

Placement at(double x, double y, double z, double degrees) { return {{x, y, z}, turnByDegrees(degrees)}; }

enum class Kind { table, bed, sofa, shelf, cupboard, crate, crate_pile, barrel, machine };

struct Item {
  Kind kind;
  double width, depth, height;
};

Item drawItem(Level& level, RoomUse use) {
  static const std::vector<Kind> living = {Kind::sofa, Kind::shelf, Kind::cupboard, Kind::table, Kind::sofa};
  static const std::vector<Kind> bedroom = {Kind::bed, Kind::cupboard, Kind::shelf, Kind::bed, Kind::table};
  static const std::vector<Kind> study = {Kind::shelf, Kind::shelf, Kind::table, Kind::cupboard, Kind::crate};
  static const std::vector<Kind> store = {Kind::crate_pile, Kind::crate,      Kind::barrel,
                                          Kind::shelf,      Kind::crate_pile, Kind::barrel};
  static const std::vector<Kind> workshop = {Kind::machine,    Kind::table, Kind::barrel,
                                             Kind::crate_pile, Kind::shelf, Kind::machine};
  const auto& kinds = use == RoomUse::living    ? living
                      : use == RoomUse::bedroom ? bedroom
                      : use == RoomUse::study   ? study
                      : use == RoomUse::store   ? store
                                                : workshop;
  switch (const Kind kind = kinds[level.random.below(static_cast<uint32_t>(kinds.size()))]) {
    case Kind::table:
      return {kind, level.pick(1.0, 1.8), level.pick(0.6, 0.8), level.pick(0.7, 0.8)};
    case Kind::bed:
      return {kind, level.pick(0.9, 1.8), level.pick(1.95, 2.15), 1.0};
    case Kind::sofa:
      return {kind, level.pick(1.4, 2.4), level.pick(0.8, 0.95), 0.85};
    case Kind::shelf:
      return {kind, level.pick(0.8, 2.0), level.pick(0.3, 0.5), level.pick(1.2, 2.2)};
    case Kind::cupboard:
      return {kind, level.pick(0.8, 1.6), level.pick(0.5, 0.65), level.pick(0.9, 2.1)};
    case Kind::crate:
      return {kind, 0.9, 0.9, level.pick(0.5, 0.85)};
    case Kind::crate_pile:
      return {kind, 1.9, 1.0, 1.7};
    case Kind::barrel:
      return {kind, 0.75, 0.75, level.pick(0.8, 1.1)};
    case Kind::machine:
      return {kind, level.pick(1.2, 2.2), level.pick(0.9, 1.4), level.pick(1.2, 1.9)};
  }
  return {Kind::crate, 0.9, 0.9, 0.7};
}

void addItem(Level& level, const Placement& placement, const Item& item) {
  switch (item.kind) {
    case Kind::table:
      addTable(level, placement, item.width, item.depth, item.height);
      break;
    case Kind::bed:
      addBed(level, placement, item.width, item.depth);
      break;
    case Kind::sofa:
      addSofa(level, placement, item.width, item.depth);
      break;
    case Kind::shelf:
      addShelf(level, placement, item.width, item.depth, item.height);
      break;
    case Kind::cupboard:
      addCupboard(level, placement, item.width, item.depth, item.height);
      break;
    case Kind::crate:
      addCrate(level, placement, item.height);
      break;
    case Kind::crate_pile:
      addCratePile(level, placement, level.pickCount(2, 4));
      break;
    case Kind::barrel:
      addBarrel(level, placement, item.height);
      break;
    case Kind::machine:
      addMachine(level, placement, item.width, item.depth, item.height);
      break;
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
    case 0:
      return {{floor.x0 + start, floor.z0 + kGap, floor.x0 + end, floor.z0 + reach}, 0.0};
    case 1:
      return {{floor.x0 + kGap, floor.z0 + start, floor.x0 + reach, floor.z0 + end}, 90.0};
    case 2:
      return {{floor.x0 + start, floor.z1 - reach, floor.x0 + end, floor.z1 - kGap}, 180.0};
    default:
      return {{floor.x1 - reach, floor.z0 + start, floor.x1 - kGap, floor.z0 + end}, 270.0};
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
