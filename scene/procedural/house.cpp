// The families "house" and "apartment": rooms with doors and windows on one or two storeys around a hall with the stairs.
#include "scene/procedural/building.h"

namespace nlg {
namespace {

// The plan: the hall is a strip along the north wall that holds the flight; the rest is parted into rooms.
struct House {
  Building building;
  double hall_m = 2.6;  // the strip's depth
  Flight flight;
  double flight_x = 0.0;  // where the flight starts
  double inner_wall_m = 0.15;
};

struct WallThickness {
  double outer_low_m, outer_high_m, inner_m;
};
constexpr WallThickness kHouseWalls = {0.25, 0.4, 0.15}, kApartmentWalls = {0.15, 0.15, 0.1};

House drawHouse(Level& level, const WallThickness& walls) {
  House house;
  Building& building = house.building;
  const double width = level.pick(9.0, 15.0);
  const double depth = level.pick(8.5, 13.0);
  building.outer = {-0.5 * width, -0.5 * depth, 0.5 * width, 0.5 * depth};
  building.wall_m = level.pick(walls.outer_low_m, walls.outer_high_m);
  house.inner_wall_m = walls.inner_m;
  building.slab_m = level.pick(0.2, 0.3);
  building.ground_m = level.pick(0.0, 0.15);
  // one or two storeys, each with a clear height of its own
  building.clear_m.assign(level.random.chance(0.65) ? 2 : 1, 0.0);
  for (double& clear : building.clear_m) clear = level.pick(2.4, 3.2);
  house.hall_m = level.pick(2.4, 3.2);
  // the flight runs along the hall's outer wall; its first 90 cm need no well above, as headroom is enough there
  if (building.storeyCount() > 1) {
    const Rect in = building.inner();
    house.flight = {building.clear_m[0] + building.slab_m, level.pick(3.6, 4.6), level.pick(0.9, 1.1), level.random.chance(0.4)};
    house.flight_x = in.x0 + 1.2 + level.random.uniform() * (in.width() - house.flight.run_m - 2.4);
    const double z0 = in.z0 + 0.02;
    building.stairwell = {house.flight_x + 0.9, z0, house.flight_x + house.flight.run_m, z0 + house.flight.width_m};
  }
  return house;
}

// A slab before the upper storey's south wall, with a door to it and a railing around it.
void addBalcony(Level& level, Building& building) {
  const double reach = level.pick(1.2, 2.0);
  const double width = level.pick(2.5, 4.5);
  const double from = level.random.uniform() * (building.inner().width() - width);
  carveDoor(building, Side::south, 1, from + 0.5 * width - 0.5, 1.0);
  const double top = building.floorHeight(1) - 0.04;  // below the floor inside: the door has a threshold
  const glm::dvec3 corner(building.inner().x0 + from, top, building.outer.z1);
  addBalcony(level, building.shell, corner, width, reach, top - 0.18);
}

void addRoof(Level& level, Building& building) {
  const Rect& out = building.outer;
  const double roof = building.roofHeight();
  if (level.random.chance(0.6)) return addGable(level, out, roof, level.pick(1.2, 2.6));
  // a parapet around a flat roof
  building.shell.fill({out.x0, roof, out.z0}, {out.x1, roof + 0.7, out.z1}, level.palette.wall);
  building.shell.carve({out.x0 + 0.25, roof, out.z0 + 0.25}, {out.x1 - 0.25, roof + 0.7, out.z1 - 0.25});
}

void addStairs(Level& level, const House& house) {
  const Building& building = house.building;
  const double z = building.inner().z0 + 0.02 + 0.5 * house.flight.width_m;
  level.mesh.beginObject("flight", Mobility::structure);
  addFlight(level, {{house.flight_x, building.ground_m, z}, {}}, house.flight, level.palette.wood);
  const Rect& well = building.stairwell;
  const double floor = building.floorHeight(1);
  addRailing(level, {{well.x0, floor, well.z1 + 0.06}, {}}, well.width());
  addRailing(level, {{well.x0 - 0.05, floor, well.z1}, turnByDegrees(90.0)}, well.depth());
}

void addRooms(Level& level, const House& house, int storey) {
  const Building& building = house.building;
  const Rect in = building.inner();
  const double wall = house.inner_wall_m;
  const double hall_end = in.z0 + house.hall_m;
  const double floor = building.floorHeight(storey);
  const double clear = building.clear_m[storey];

  // the wall between hall and rooms, with one or two doors
  const int door_count = in.width() > 9.0 ? 2 : 1;
  std::vector<Rect> keep_free;
  BrushGrid grid;
  grid.fill({in.x0, floor, hall_end}, {in.x1, floor + clear, hall_end + wall}, level.palette.inner_wall);
  for (int door = 0; door < door_count; ++door) {
    const double share = in.width() / door_count;
    const double x = in.x0 + share * door + 0.4 + level.random.uniform() * (share - 1.8);
    grid.carve({x, floor, hall_end}, {x + 0.9, floor + 2.05, hall_end + wall});
    keep_free.push_back(Rect{x, hall_end, x + 0.9, hall_end + wall}.grown(0.6));
  }
  grid.emitObject(level.mesh, "hall wall", Mobility::structure);

  // a metre before and behind the flight stays free
  if (building.storeyCount() > 1)
    keep_free.push_back(
        {house.flight_x - 1.0, in.z0, house.flight_x + house.flight.run_m + 1.0, in.z0 + house.flight.width_m + 0.2});
  // what the hall leaves is parted into rooms
  PlanOptions options;
  options.min_side_m = level.pick(2.5, 3.2);
  options.wall_m = wall;
  const Rect rest{in.x0, hall_end + wall, in.x1, in.z1};
  std::vector<Room> rooms = partStorey(level, building, storey, rest, options, keep_free);
  for (const Room& room : rooms) {
    const RoomUse uses[] = {RoomUse::living, RoomUse::bedroom, RoomUse::study, RoomUse::living};
    const RoomUse use = storey == 0 ? uses[level.random.below(4)] : uses[1 + level.random.below(2)];
    furnishRoom(level, room, use, level.random.uniform(0.6, 1.1));
  }
  // the hall itself is nearly empty
  Room hall{{in.x0, in.z0, in.x1, hall_end}, floor, clear, keep_free};
  for (const Rect& opening : building.openingsOf(storey)) hall.keep_free.push_back(opening);
  furnishRoom(level, hall, RoomUse::study, 0.3);
}

void build(Level& level, const WallThickness& walls) {
  House house = drawHouse(level, walls);
  Building& building = house.building;
  addGround(level, building, level.pick(2.0, 5.0));
  fillShell(level, building);
  for (int storey = 0; storey < building.storeyCount(); ++storey) carveWindows(level, building, storey, 0.75);
  const bool enters_west = level.random.chance(0.5);
  carveDoor(building, enters_west ? Side::west : Side::east, 0, house.hall_m - 1.3, 1.0);
  if (level.random.chance(0.6)) {
    const double along = level.random.uniform(1.0, 6.0);
    carveDoor(building, Side::south, 0, along, level.pick(1.2, 2.0));
  }
  if (building.storeyCount() > 1 && level.random.chance(0.7)) addBalcony(level, building);
  addRoof(level, building);
  building.shell.emitObject(level.mesh, "shell", Mobility::structure);
  if (building.storeyCount() > 1) addStairs(level, house);
  for (int storey = 0; storey < building.storeyCount(); ++storey) addRooms(level, house, storey);
}

}  // namespace

void buildHouse(Level& level) { build(level, kHouseWalls); }
void buildApartment(Level& level) { build(level, kApartmentWalls); }

}  // namespace nlg
