// The plan "flat": a corridor with rooms on both sides and a living room across its end.
#include <algorithm>

#include "scene/interiors/furnisher.h"
#include "scene/interiors/interiors.h"

namespace nlg {
namespace {

// Rooms along one side of the corridor, from the entrance to the living room.
std::vector<HomeUse> drawRow(Level& level, double length, bool has_kitchen) {
  std::vector<HomeUse> row;
  if (has_kitchen) {
    row = {HomeUse::toilet, HomeUse::bedroom, HomeUse::kitchen};
    if (length < 7.0) row.erase(row.begin());
    if (length > 9.5) row.insert(row.begin() + 1, HomeUse::child);
  } else {
    row = {HomeUse::bath, level.random.chance(0.5) ? HomeUse::child : HomeUse::study, HomeUse::bedroom};
    if (length < 7.0) row.erase(row.begin() + 1);
    if (length > 9.5 && level.random.chance(0.6)) row.insert(row.begin(), HomeUse::store);
  }
  return row;
}

double weightOf(HomeUse use) {
  if (use == HomeUse::toilet) return 0.55;
  if (use == HomeUse::store) return 0.7;
  if (use == HomeUse::bath) return 0.95;
  return use == HomeUse::bedroom ? 1.6 : 1.3;
}

std::vector<size_t> addRow(Home& home, const std::vector<HomeUse>& row, double x0, double x1, double z0, double z1,
                           double clear) {
  std::vector<double> weights;
  for (const HomeUse use : row) weights.push_back(weightOf(use));
  const std::vector<double> x = partLength(home.level, x0, x1, home.inner_wall_m, weights);
  std::vector<size_t> rooms;
  for (size_t i = 0; i < row.size(); ++i) rooms.push_back(home.addRoom(row[i], {x[2 * i], z0, x[2 * i + 1], z1}, 0.0, clear));
  return rooms;
}

void addWindows(Home& home, double clear) {
  const double head = std::min(home.level.pick(2.0, 2.3), clear - 0.15);
  const double sill = home.level.pick(0.75, 1.0);
  for (size_t i = 0; i < home.rooms.size(); ++i) {
    const HomeUse use = home.rooms[i].use;
    if (use == HomeUse::hall || use == HomeUse::store) continue;
    const bool is_wet = use == HomeUse::bath || use == HomeUse::toilet;
    home.windows(i, 0.85, is_wet ? 1.3 : use == HomeUse::kitchen ? 1.05 : sill, head);
  }
}

// A slab with a railing before the living room's door.
void addBalcony(Home& home, size_t living, const Rect& outer) {
  Level& level = home.level;
  const HomeRoom& room = home.rooms[living];
  const double width = std::min(3.5, room.floor.width() - 0.2), reach = level.pick(1.0, 1.8);
  const double x0 = room.floor.x0 + (room.floor.width() - width) * level.random.uniform();
  home.doorOutside(living, Side::south, x0 + 0.5 * width - 0.45 - room.floor.x0, {0.9, 2.1, true}, false);
  addBalcony(level, home.shell, {x0, -0.03, outer.z1}, width, reach, -0.2);
}

}  // namespace

void buildFlat(Home& home) {
  // outer walls and slabs, on the ground or 3 m above it
  Level& level = home.level;
  home.outer_wall_m = pickFine(level, 0.15, 0.3);
  home.inner_wall_m = pickFine(level, 0.07, 0.12);
  const double width = level.pick(10.5, 15.0), depth = level.pick(7.6, 10.0), clear = level.pick(2.4, 2.9);
  const Rect outer{-0.5 * width, -0.5 * depth, 0.5 * width, 0.5 * depth};
  const Rect in = outer.grown(-home.outer_wall_m);
  home.outsides = {outer};
  home.shell.fill({outer.x0, -0.25, outer.z0}, {outer.x1, clear + 0.25, outer.z1}, level.roomFaces());
  addGroundPlate(home, outer.grown(level.pick(1.5, 3.0)), level.random.chance(0.5) ? -0.25 : -3.0);

  // a corridor from the front door to the living room, and a row of rooms on either side
  const double wall = home.inner_wall_m;
  const double corridor = level.pick(1.15, 1.6), living = level.pick(3.8, 5.2);
  const double rows = in.depth() - corridor - 2.0 * wall;
  const double north = rows * level.random.uniform(0.44, 0.56);
  const double end = in.x1 - living - wall;
  const double z0 = in.z0 + north + wall, z1 = z0 + corridor;
  const size_t hall = home.addRoom(HomeUse::hall, {in.x0, z0, end, z1}, 0.0, clear);
  // one of the two rows has the kitchen
  const bool kitchen_north = level.random.chance(0.5);
  const std::vector<HomeUse> north_uses = drawRow(level, end - in.x0, kitchen_north);
  const std::vector<HomeUse> south_uses = drawRow(level, end - in.x0, !kitchen_north);
  std::vector<size_t> rooms = addRow(home, north_uses, in.x0, end, in.z0, in.z0 + north, clear);
  const std::vector<size_t> south_rooms = addRow(home, south_uses, in.x0, end, z1 + wall, in.z1, clear);
  rooms.insert(rooms.end(), south_rooms.begin(), south_rooms.end());
  const size_t last = home.addRoom(HomeUse::living, {end + wall, in.z0, in.x1, in.z1}, 0.0, clear);

  // doors after rooms: a door needs both of its rooms
  home.doorOutside(hall, Side::west, 0.1, {0.95, 2.05, true}, true);
  for (const size_t room : rooms) {
    const double door = home.rooms[room].use == HomeUse::toilet ? 0.75 : 0.85;
    home.connect(room, hall, {door, 2.03, true});
  }
  // a wide opening has no leaf: light of the living room reaches the corridor
  const bool is_wide = level.random.chance(0.4) && corridor > 1.3;
  home.connect(last, hall, {is_wide ? 1.05 : 0.88, is_wide ? 2.2 : 2.03, !is_wide});
  // an open kitchen: a passage to the living room besides the corridor's door
  for (const size_t room : rooms) {
    if (home.rooms[room].use == HomeUse::kitchen && level.random.chance(0.6)) home.connect(room, last, {1.2, 2.1, false});
  }
  if (level.random.chance(0.7)) addBalcony(home, last, outer);
  // windows and furniture last, when all doors are in place
  addWindows(home, clear);
  for (HomeRoom& room : home.rooms) furnish(home, room);
}

}  // namespace nlg
