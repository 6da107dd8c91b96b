// The plan "villa": a hall of double height between two rows of columns with arches, galleries above the aisles, wings of two
// storeys at both ends, a garden with trees before it.

#include "scene/interiors/furnisher.h"
#include "scene/interiors/interiors.h"
#include "scene/procedural/building.h"

namespace nlg {
namespace {

struct Villa {
  Rect outer, in, hall;
  Columns columns;
  int bay_count = 4;
  double nave = 4.5, aisle = 2.4, slab = 0.3, upper_m = 2.7, gallery_m = 0.0, run_m = 4.5, flight_m = 1.5;

  double lower() const { return gallery_m - slab; }  // clear height below the galleries
  double west() const { return hall.x0 + 1.8; }      // the gallery across the hall's west end reaches to here
  double naveZ0() const { return -0.5 * nave; }
  double naveZ1() const { return 0.5 * nave; }
};

Villa drawVilla(Home& home) {
  Level& level = home.level;
  Villa villa;
  villa.columns.bay = level.pick(2.3, 2.9);
  villa.columns.column_m = level.pick(1.9, 2.3);
  villa.columns.radius = level.pick(0.14, 0.22);
  villa.columns.side_count = level.random.chance(0.25) ? 4 : level.pickCount(8, 12);
  villa.columns.has_arches = level.random.chance(0.75);
  villa.bay_count = level.pickCount(3, 4);
  villa.nave = level.pick(4.2, 5.4);
  villa.aisle = level.pick(2.0, 2.6);
  villa.gallery_m = villa.columns.column_m + villa.columns.archRise() + 0.15 + villa.slab;
  villa.run_m = level.pick(1.35, 1.5) * villa.gallery_m;
  // the last column of a row stands before the wall, not in it
  const double length = 1.8 + villa.bay_count * villa.columns.bay + 1.6 * villa.columns.radius;
  villa.hall = {-0.5 * length, villa.naveZ0() - villa.aisle, 0.5 * length, villa.naveZ1() + villa.aisle};
  const double west = level.pick(3.6, 4.6), east = level.pick(3.4, 4.4), wall = home.inner_wall_m;
  villa.in = {villa.hall.x0 - wall - west, villa.hall.z0, villa.hall.x1 + wall + east, villa.hall.z1};
  villa.outer = villa.in.grown(home.outer_wall_m);
  return villa;
}

// A wing on both storeys; its rooms open to the hall and to the galleries.
void addWing(Home& home, const Villa& villa, double x0, double x1, size_t hall, const std::vector<size_t>& galleries,
             const std::vector<HomeUse>& lower, const std::vector<HomeUse>& upper) {
  for (const bool is_upper : {false, true}) {
    const std::vector<HomeUse>& uses = is_upper ? upper : lower;
    // each storey parts the wing by itself: its walls need not stand above those below
    const std::vector<double> z =
        partLength(home.level, villa.in.z0, villa.in.z1, home.inner_wall_m, std::vector<double>(uses.size(), 1.0));
    const double floor = is_upper ? villa.gallery_m : 0.0, clear = is_upper ? villa.upper_m : villa.lower();
    size_t before = 0;
    for (size_t i = 0; i < uses.size(); ++i) {
      const size_t room = home.addRoom(uses[i], {x0, z[2 * i], x1, z[2 * i + 1]}, floor, clear);
      const DoorShape door{0.88, 2.05, true};
      bool is_reached = false;
      // below, rooms open to the hall, often without a leaf; above, to whichever gallery they border
      if (!is_upper) {
        is_reached = home.connect(room, hall, {home.level.random.chance(0.4) ? 1.4 : 0.9, 2.1, home.level.random.chance(0.5)});
      } else {
        for (const size_t gallery : galleries) is_reached = is_reached || home.connect(room, gallery, door);
      }
      // a room that borders none of them is reached through its neighbour
      if (!is_reached && i > 0) home.connect(room, before, door);
      before = room;
    }
  }
}

void addGalleries(Home& home, const Villa& villa) {
  Level& level = home.level;
  const Rect& h = villa.hall;
  const double top = villa.gallery_m, x0 = villa.west();
  BrushGrid slab;
  const BrushMaterials faces(level.palette.stone, level.palette.floor, level.palette.ceiling);
  slab.fill({h.x0, villa.lower(), h.z0}, {h.x1, top, villa.naveZ0()}, faces);
  slab.fill({h.x0, villa.lower(), villa.naveZ1()}, {h.x1, top, h.z1}, faces);
  slab.fill({h.x0, villa.lower(), h.z0}, {x0, top, h.z1}, faces);
  slab.emitObject(level.mesh, "galleries", Mobility::structure);
  for (const double z : {villa.naveZ0() - 0.06, villa.naveZ1() + 0.06}) addRailing(level, {{x0, top, z}, {}}, h.x1 - x0);
  // beside the flight's arrival at the west gallery
  const double gap = 0.5 * villa.flight_m + 0.05;
  addRailing(level, {{x0 - 0.06, top, villa.naveZ1()}, turnByDegrees(90.0)}, villa.naveZ1() - gap);
  addRailing(level, {{x0 - 0.06, top, -gap}, turnByDegrees(90.0)}, villa.naveZ1() - gap);
}

void addGarden(Home& home, const Villa& villa) {
  Level& level = home.level;
  HomeRoom garden;
  garden.use = HomeUse::terrace;
  garden.floor = {villa.outer.x0, villa.outer.z1 + 1.2, villa.outer.x1, villa.outer.z1 + level.pick(7.5, 10.0)};
  garden.floor_m = -0.05;
  garden.clear_m = 14.0;
  garden.has_ceiling = false;
  Rect ground = villa.outer.grown(1.5);
  ground.z1 = garden.floor.z1 + 1.0;
  addGroundPlate(home, ground, garden.floor_m);
  home.rooms.push_back(garden);
}

// Lamps below the galleries, and below the roof in the middle.
void hangHallLamps(Home& home, const Villa& villa, HomeRoom& hall) {
  const double low = hall.clear_m;
  hall.has_ceiling = true;
  for (int bay = 0; bay < villa.bay_count; ++bay) {
    const double x = villa.west() + (bay + 0.5) * villa.columns.bay;
    for (const double sign : {-1.0, 1.0}) hangLamp(home, hall, {x, sign * 0.5 * (villa.nave + villa.aisle)});
    hall.clear_m = villa.gallery_m + villa.upper_m;
    if (bay % 2 == 0) hangLamp(home, hall, {x, 0.0});
    hall.clear_m = low;
  }
  hall.has_ceiling = false;
}

}  // namespace

void buildVilla(Home& home) {
  Level& level = home.level;
  home.outer_wall_m = pickFine(level, 0.2, 0.3);
  home.inner_wall_m = pickFine(level, 0.08, 0.12);
  const Villa villa = drawVilla(home);
  const Rect& h = villa.hall;
  const double roof = villa.gallery_m + villa.upper_m;
  home.outsides = {villa.outer};
  home.shell.fill({villa.outer.x0, -0.5, villa.outer.z0}, {villa.outer.x1, roof + 0.3, villa.outer.z1}, level.roomFaces());
  // the hall reaches up to the roof, galleries and columns stand within it
  const size_t hall = home.addRoom(HomeUse::salon, h, 0.0, villa.lower());
  home.shell.carve({h.x0, villa.lower(), h.z0}, {h.x1, roof, h.z1});  // up to the roof; the galleries stand in it
  const auto gallery = [&](const Rect& floor) { return home.addRoom(HomeUse::gallery, floor, villa.gallery_m, villa.upper_m); };
  home.rooms[hall].has_ceiling = false;
  const std::vector<size_t> galleries = {gallery({h.x0, h.z0, h.x1, villa.naveZ0() - 0.12}),
                                         gallery({h.x0, villa.naveZ1() + 0.12, h.x1, h.z1}),
                                         gallery({h.x0, villa.naveZ0(), villa.west() - 0.12, villa.naveZ1()})};
  // sides of a gallery that are open to the hall
  home.rooms[galleries[0]].open_sides = {Side::south};
  home.rooms[galleries[1]].open_sides = {Side::north};
  home.rooms[galleries[2]].open_sides = {Side::north, Side::east, Side::south};
  const double wall = home.inner_wall_m;
  // wings with two to three rooms a storey, reached from the hall and from the galleries
  addWing(home, villa, villa.in.x0, h.x0 - wall, hall, galleries, {HomeUse::kitchen, HomeUse::dining},
          {HomeUse::bedroom, HomeUse::bath, HomeUse::bedroom});
  addWing(home, villa, h.x1 + wall, villa.in.x1, hall, galleries, {HomeUse::study, HomeUse::toilet, HomeUse::living},
          {HomeUse::child, HomeUse::study, HomeUse::bedroom});

  // doors to the garden at the south, the entrance at the north
  const int bays = villa.bay_count;
  for (int bay = 0; bay < bays; ++bay) {
    const double middle = 1.8 + (bay + 0.5) * villa.columns.bay;
    const double width = level.pick(1.1, 1.5);
    if (level.random.chance(0.7)) home.doorOutside(hall, Side::south, middle - 0.5 * width, {width, 2.3, false}, false);
  }
  home.doorOutside(hall, Side::north, 1.8 + level.random.uniform(0.0, 3.0), {1.1, 2.2, true}, true);
  const double sill = level.pick(0.6, 0.9);
  for (size_t i = 0; i < home.rooms.size(); ++i) home.windows(i, 0.75, home.rooms[i].use == HomeUse::kitchen ? 1.05 : sill, 2.15);

  // columns below the galleries' edges; nothing is put where they stand
  addGalleries(home, villa);
  for (const double z : {villa.naveZ0() + 0.25, villa.naveZ1() - 0.25}) {
    addColumnRow(level, villa.columns, {{villa.west(), 0.0, z}, {}}, bays, villa.lower(), true);
    for (int i = 0; i <= bays; ++i) {
      const double x = villa.west() + i * villa.columns.bay, reach = 1.5 * villa.columns.radius;
      home.rooms[hall].solids.push_back({Rect{x, z, x, z}.grown(reach), 0.0, villa.lower()});
    }
  }
  // the flight rises to the west, in the middle of the hall
  level.mesh.beginObject("flight", Mobility::structure);
  addFlight(level, {{villa.west() + villa.run_m, 0.0, 0.0}, turnByDegrees(180.0)},
            {villa.gallery_m, villa.run_m, villa.flight_m, false}, level.palette.stone);
  home.rooms[hall].solids.push_back(
      {{villa.west(), -0.5 * villa.flight_m - 0.1, villa.west() + villa.run_m + 1.0, 0.5 * villa.flight_m + 0.1},
       0.0,
       villa.lower()});
  addGarden(home, villa);
  hangHallLamps(home, villa, home.rooms[hall]);
  for (HomeRoom& room : home.rooms) furnish(home, room);
}

}  // namespace nlg
