// The plan "townhouse": narrow, two storeys and an attic under slopes; straight flights above each other along one wall.
#include <algorithm>

#include "scene/interiors/furnisher.h"
#include "scene/interiors/interiors.h"

namespace nlg {
namespace {

struct Townhouse {
  Rect outer, in;
  std::vector<double> floor_m, clear_m;  // of ground floor, upper floor and attic
  double hall_m = 2.1;                   // depth of the strip that holds the stairs
  double hall_x1 = 0.0;                  // where it ends
  double flight_x = 0.0, run_m = 3.8, flight_m = 0.9;
  double slope = 1.0, knee_m = 1.0;

  Rect well() const { return {flight_x + 0.9, in.z0, flight_x + run_m, in.z0 + flight_m}; }
  // Underside of the roof above the attic's floor at this distance from the ridge.
  double under(double across) const { return knee_m + slope * (0.5 * in.width() - (across < 0.0 ? -across : across)); }
};

Townhouse drawTownhouse(Home& home) {
  Level& level = home.level;
  Townhouse house;
  const double length = level.pick(9.5, 12.5), depth = level.pick(5.6, 7.0);
  house.outer = {-0.5 * length, -0.5 * depth, 0.5 * length, 0.5 * depth};
  house.in = house.outer.grown(-home.outer_wall_m);
  const double slab = level.pick(0.2, 0.3);
  house.clear_m = {level.pick(2.4, 2.8), level.pick(2.35, 2.6), 2.2};
  house.floor_m = {0.0, house.clear_m[0] + slab, house.clear_m[0] + house.clear_m[1] + 2.0 * slab};
  house.run_m = level.pick(3.6, 4.2);
  house.flight_m = level.pick(0.85, 0.95);
  house.hall_m = house.flight_m + level.pick(1.1, 1.3);
  house.flight_x = house.in.x0 + 1.1;
  house.hall_x1 = house.flight_x + house.run_m + 1.05;
  house.slope = level.random.uniform(0.45, 0.7);
  house.knee_m = level.random.uniform(0.8, 1.2);
  return house;
}

void addFlights(Home& home, const Townhouse& house, size_t ground_hall, size_t upper_hall) {
  Level& level = home.level;
  const double z = house.in.z0 + 0.02 + 0.5 * (house.flight_m - 0.02);
  for (int storey = 0; storey < 2; ++storey) {
    const double rise = house.floor_m[storey + 1] - house.floor_m[storey];
    level.mesh.beginObject("flight", Mobility::structure);
    const Placement foot{{house.flight_x, house.floor_m[storey], z}, {}};
    addFlight(level, foot, {rise, house.run_m, house.flight_m - 0.02, true}, level.palette.wood);
    const Rect& well = house.well();
    const double top = house.floor_m[storey + 1];
    addRailing(level, {{well.x0, top, well.z1 + 0.06}, {}}, well.width());
    addRailing(level, {{well.x0 - 0.05, top, well.z1}, turnByDegrees(90.0)}, well.depth());
    const Rect stairs{house.flight_x - 0.9, house.in.z0, house.flight_x + house.run_m + 0.95, house.in.z0 + house.flight_m + 0.1};
    HomeRoom& room = home.rooms[storey == 0 ? ground_hall : upper_hall];
    room.solids.push_back({stairs, room.floor_m, room.floor_m + room.clear_m});
  }
}

// The ridge runs across the house, so that the stairs arrive below it. The two slopes are one solid. Below them, between the shell's
// knee walls, stand gable walls with a window each.
void addRoof(Home& home, const Townhouse& house) {
  Level& level = home.level;
  const double attic = house.floor_m[2];
  const double half = 0.5 * house.outer.width(), reach = 0.5 * house.outer.depth();
  const Placement frame{{0.0, attic, 0.0}, {}};  // the ridge runs along z
  const auto under = [&](double across) { return house.under(across); };
  level.mesh.beginObject("roof", Mobility::structure);
  const double eaves = half + 0.35, thick = 0.22;
  addProfile(level.mesh, frame,
             {{-eaves, under(eaves), under(eaves) + thick},
              {0.0, under(0.0), under(0.0) + thick},
              {eaves, under(eaves), under(eaves) + thick}},
             -reach - 0.25, reach + 0.25, level.palette.roof);
  const double window = level.pick(0.4, 0.6), sill = level.pick(0.8, 1.0), head = std::min(sill + 1.2, under(window) - 0.15);
  for (const double sign : {-1.0, 1.0}) {
    const double z0 = sign > 0 ? reach - home.outer_wall_m : -reach, z1 = sign > 0 ? reach : -reach + home.outer_wall_m;
    level.mesh.beginObject("gable", Mobility::structure);
    constexpr double kInto = 0.04;  // into the slopes
    const auto top = [&](double across) { return under(across) + kInto; };
    const auto add = [&](const std::vector<ProfilePoint>& profile) {
      addProfile(level.mesh, frame, profile, z0, z1, level.palette.wall);
    };
    add({{-half, 0.0, top(half)}, {-window, 0.0, top(window)}});
    add({{window, 0.0, top(window)}, {half, 0.0, top(half)}});
    add({{-window, 0.0, sill}, {window, 0.0, sill}});
    add({{-window, head, top(window)}, {0.0, head, top(0.0)}, {window, head, top(window)}});
  }
}

// The part of the attic where one can stand and furniture fits, beside the stairs.
void addAttic(Home& home, const Townhouse& house) {
  const double attic = house.floor_m[2];
  const double height = 1.6;
  const double reach = 0.5 * house.in.width() - std::max(0.0, height - house.knee_m) / house.slope;
  HomeRoom room;
  room.use = HomeUse::attic;
  room.floor = {-reach, house.in.z0, reach, house.in.z1};
  room.floor_m = attic;
  room.clear_m = height;
  room.has_ceiling = false;
  room.open_sides = {Side::west, Side::east};
  const Rect stairs{house.flight_x, house.in.z0, house.flight_x + house.run_m + 1.0, house.in.z0 + house.flight_m + 0.9};
  room.solids.push_back({stairs, attic, attic + 2.2});
  home.rooms.push_back(room);
}

}  // namespace

void buildTownhouse(Home& home) {
  Level& level = home.level;
  home.outer_wall_m = pickFine(level, 0.18, 0.3);
  home.inner_wall_m = pickFine(level, 0.07, 0.12);
  const Townhouse house = drawTownhouse(home);
  const Rect &outer = house.outer, &in = house.in;
  const double wall = home.inner_wall_m, attic = house.floor_m[2];
  home.outsides = {outer};
  // two storeys as one block; at the eaves the attic's walls reach up to the roof
  addGroundPlate(home, outer.grown(level.pick(2.0, 4.0)), -0.1);
  const double knee_top = attic + house.under(0.5 * outer.width()) + 0.04;
  home.shell.fill({outer.x0, -0.5, outer.z0}, {outer.x1, attic, outer.z1}, level.roomFaces());
  home.shell.fill({outer.x0, attic, outer.z0}, {outer.x0 + home.outer_wall_m, knee_top, outer.z1}, level.palette.wall);
  home.shell.fill({outer.x1 - home.outer_wall_m, attic, outer.z0}, {outer.x1, knee_top, outer.z1}, level.palette.wall);

  // below: hall, living room, kitchen. Above: landing, bedrooms, bath. Both halls lie along the same flights
  const double hall_z1 = in.z0 + house.hall_m, x1 = house.hall_x1;
  std::vector<size_t> halls;
  for (int storey = 0; storey < 2; ++storey) {
    const double floor = house.floor_m[storey], clear = house.clear_m[storey];
    const size_t hall = home.addRoom(HomeUse::hall, {in.x0, in.z0, x1, hall_z1}, floor, clear);
    halls.push_back(hall);
    // the foot of the flight needs the wall beside it
    const DoorShape beside_stairs{0.82, 2.03, true, in.z0 + house.flight_m + 0.1, hall_z1};
    if (storey == 0) {
      const size_t living = home.addRoom(HomeUse::living, {in.x0, hall_z1 + wall, x1, in.z1}, floor, clear);
      const size_t kitchen = home.addRoom(HomeUse::kitchen, {x1 + wall, in.z0, in.x1, in.z1}, floor, clear);
      home.doorOutside(hall, Side::west, house.flight_m + 0.1, {0.9, 2.03, true}, true);
      home.connect(living, hall, {0.88, 2.03, true});
      home.connect(kitchen, hall, beside_stairs);
      home.connect(kitchen, living, {level.pick(0.9, 1.6), 2.1, false});
      home.doorOutside(kitchen, Side::east, level.random.uniform(0.2, 3.0), {0.9, 2.1, true}, false);
    } else {
      const std::vector<double> x = partLength(level, in.x0, x1, wall, {1.3, 1.0});
      const size_t bedroom = home.addRoom(HomeUse::bedroom, {x[0], hall_z1 + wall, x[1], in.z1}, floor, clear);
      const size_t child = home.addRoom(HomeUse::child, {x[2], hall_z1 + wall, x[3], in.z1}, floor, clear);
      const size_t bath = home.addRoom(HomeUse::bath, {x1 + wall, in.z0, in.x1, hall_z1 + 0.3}, floor, clear);
      const size_t study = home.addRoom(level.random.chance(0.5) ? HomeUse::study : HomeUse::bedroom,
                                        {x1 + wall, hall_z1 + 0.3 + wall, in.x1, in.z1}, floor, clear);
      home.connect(bedroom, hall, {0.82, 2.03, true});
      home.connect(child, hall, {0.82, 2.03, true});
      home.connect(bath, hall, {0.75, 2.03, true, in.z0 + house.flight_m + 0.1, hall_z1});
      home.connect(study, child, {0.82, 2.03, true});
    }
  }
  // the stairwell through both upper floors, slab included
  for (const double floor : {house.floor_m[1], attic}) {
    const Rect well = house.well();
    home.shell.carve({well.x0, floor - 0.31, well.z0}, {well.x1, floor, well.z1});
  }
  // sills by use: 1.05 m above worktops, 1.3 m in bathrooms; the hall has no window
  const double head = level.pick(2.0, 2.2), sill = level.pick(0.75, 0.95);
  for (size_t i = 0; i < home.rooms.size(); ++i) {
    const HomeUse use = home.rooms[i].use;
    if (use != HomeUse::hall) home.windows(i, 0.8, use == HomeUse::bath ? 1.3 : use == HomeUse::kitchen ? 1.05 : sill, head);
  }
  addFlights(home, house, halls[0], halls[1]);
  // the attic's room ends at the slopes of the roof
  addRoof(home, house);
  addAttic(home, house);
  for (HomeRoom& room : home.rooms) furnish(home, room);
}

}  // namespace nlg
