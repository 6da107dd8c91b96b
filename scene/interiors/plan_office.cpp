// The plan "office": an open floor with columns and desks, small rooms along one wall, boxes of glass in its corners.

#include "scene/interiors/furnisher.h"
#include "scene/interiors/interiors.h"
#include "scene/procedural/building.h"

namespace nlg {
namespace {

// Columns on a grid in the open floor; they are solids of it.
void addColumns(Home& home, HomeRoom& room) {
  Level& level = home.level;
  const double distance = level.pick(4.5, 6.0), radius = level.pick(0.15, 0.3);
  const bool is_round = level.random.chance(0.4);
  for (double x = room.floor.x0 + 0.5 * distance; x < room.floor.x1 - 1.0; x += distance) {
    for (double z = room.floor.z0 + 0.5 * distance; z < room.floor.z1 - 1.0; z += distance) {
      const Box box{Rect{x, z, x, z}.grown(radius), room.floor_m, room.floor_m + room.clear_m};
      if (!room.isFree(box)) continue;
      room.solids.push_back(box);
      level.mesh.beginObject("column", Mobility::structure);
      const Placement foot{{x, room.floor_m, z}, turnByDegrees(is_round ? 0.0 : 45.0)};
      const double reach = is_round ? radius : 1.4142 * radius;
      addLathe(level.mesh, foot, {{0.0, reach}, {room.clear_m, reach}}, is_round ? 14 : 4, level.palette.stone);
    }
  }
}

}  // namespace

void buildOffice(Home& home) {
  Level& level = home.level;
  // outer walls and slabs; partitions of the boxes are panes of 2 to 4 cm
  home.outer_wall_m = pickFine(level, 0.2, 0.3);
  home.inner_wall_m = pickFine(level, 0.08, 0.12);
  const double glass = 0.01 * level.pickCount(2, 4);
  const double width = level.pick(16.0, 23.0), depth = level.pick(12.0, 16.0), clear = level.pick(2.7, 3.3);
  const Rect outer{-0.5 * width, -0.5 * depth, 0.5 * width, 0.5 * depth};
  const Rect in = outer.grown(-home.outer_wall_m);
  home.outsides = {outer};
  home.shell.fill({outer.x0, -0.3, outer.z0}, {outer.x1, clear + 0.3, outer.z1}, level.roomFaces());
  addGroundPlate(home, outer.grown(2.0), -0.3);

  // small rooms at the north, the open floor between boxes of glass at the west and the east
  const double wall = home.inner_wall_m, core = level.pick(2.8, 3.8);
  const double core_z1 = in.z0 + core, open_z0 = core_z1 + wall;
  const std::vector<HomeUse> core_uses = {HomeUse::toilet,
                                          HomeUse::toilet,
                                          HomeUse::store,
                                          HomeUse::pantry,
                                          level.random.chance(0.5) ? HomeUse::meeting : HomeUse::study,
                                          HomeUse::meeting};
  // shares of the length: toilets and store get the least
  const std::vector<double> x = partLength(level, in.x0, in.x1, wall, {0.5, 0.5, 0.7, 1.2, 1.2, 1.3});
  std::vector<size_t> core_rooms;
  for (size_t i = 0; i < core_uses.size(); ++i)
    core_rooms.push_back(home.addRoom(core_uses[i], {x[2 * i], in.z0, x[2 * i + 1], core_z1}, 0.0, clear));

  const double box = level.pick(3.0, 4.2);
  const bool has_east = level.random.chance(0.6);
  const double open_x0 = in.x0 + box + glass, open_x1 = has_east ? in.x1 - box - glass : in.x1;
  // the walls of the boxes are of glass
  home.shell.fill({in.x0 + box, 0.0, open_z0}, {open_x0, clear, in.z1}, home.glass_material);
  if (has_east) home.shell.fill({open_x1, 0.0, open_z0}, {in.x1 - box, clear, in.z1}, home.glass_material);
  const size_t open = home.addRoom(HomeUse::open_office, {open_x0, open_z0, open_x1, in.z1}, 0.0, clear);
  const int west_count = level.pickCount(2, 3);
  std::vector<size_t> boxes;
  for (const bool is_east : {false, true}) {
    if (is_east && !has_east) continue;
    const double x0 = is_east ? in.x1 - box : in.x0, x1 = is_east ? in.x1 : in.x0 + box;
    const std::vector<double> z = partLength(level, open_z0, in.z1, glass, std::vector<double>(west_count, 1.0));
    home.shell.fill({x0, 0.0, open_z0}, {x1, clear, in.z1}, home.glass_material);
    for (int i = 0; i < west_count; ++i) {
      const HomeUse use = level.random.chance(0.4)   ? HomeUse::study
                          : level.random.chance(0.3) ? HomeUse::lounge
                                                     : HomeUse::meeting;
      boxes.push_back(home.addRoom(use, {x0, z[2 * i], x1, z[2 * i + 1]}, 0.0, clear));
    }
  }
  // boxes open to the open floor
  for (const size_t room : boxes) home.connect(room, open, {0.9, 2.1, level.random.chance(0.8)});
  // what does not border the open floor is reached through a box, else through a neighbour
  for (const size_t room : core_rooms) {
    bool is_reached = home.connect(room, open, {0.85, 2.03, true});
    for (const size_t other : boxes) is_reached = is_reached || home.connect(room, other, {0.85, 2.03, true});
    for (const size_t other : core_rooms)
      is_reached = is_reached || (other != room && home.connect(room, other, {0.85, 2.03, true}));
  }
  // entrance, then windows for all but toilets and store
  home.doorOutside(open, Side::south, level.random.uniform(0.5, 6.0), {level.pick(1.2, 2.0), 2.2, false}, false);
  const double head = clear - level.pick(0.2, 0.5), sill = level.pick(0.3, 0.9);
  for (size_t i = 0; i < home.rooms.size(); ++i) {
    const HomeUse use = home.rooms[i].use;
    if (use == HomeUse::toilet || use == HomeUse::store) continue;
    home.windows(i, 0.9, sill, head);
  }
  addColumns(home, home.rooms[open]);
  for (HomeRoom& room : home.rooms) furnish(home, room);
}

}  // namespace nlg
