// Furniture of each kind of room.
#include <algorithm>
#include <cmath>

#include "scene/interiors/fittings.h"
#include "scene/interiors/furnisher.h"
#include "scene/procedural/furniture.h"

namespace nlg {
namespace {

using Use = FurnitureUse;

void addRug(Home& home, HomeRoom& room, const glm::dvec2& middle, double degrees) {
  const std::optional<Piece> piece = drawPiece(home, Use::rug, {room.floor.width() - 0.4, room.floor.depth() - 0.4, 0.05});
  if (!piece) return;
  const Rect area = footprint(*piece, middle, degrees);
  const Rect within = room.floor.grown(-0.05);
  const glm::dvec2 moved{std::clamp(middle.x, within.x0 + 0.5 * area.width(),
                                    std::max(within.x0 + 0.5 * area.width(), within.x1 - 0.5 * area.width())),
                         std::clamp(middle.y, within.z0 + 0.5 * area.depth(),
                                    std::max(within.z0 + 0.5 * area.depth(), within.z1 - 0.5 * area.depth()))};
  if (area.width() > within.width() || area.depth() > within.depth()) return;
  emitPiece(home, *piece, {{moved.x, room.floor_m, moved.y}, turnByDegrees(degrees)});
}

void addCurtainsOf(Home& home, HomeRoom& room, double share) {
  const std::vector<RoomOpening> openings = room.openings;
  const bool has_curtains = home.level.random.chance(share);
  for (const RoomOpening& opening : openings) {
    if (has_curtains && opening.kind == RoomOpening::Kind::window) addCurtains(home, room, opening);
  }
}

// Radiators under windows.
void addRadiators(Home& home, HomeRoom& room) {
  const std::optional<Piece> piece = drawPiece(home, Use::radiator, {1.5, 0.3, 0.95});
  if (!piece) return;
  const std::vector<RoomOpening> openings = room.openings;
  for (const RoomOpening& opening : openings) {
    if (opening.kind != RoomOpening::Kind::window || !home.level.random.chance(0.6)) continue;
    standAtWall(home, room, *piece, {opening.side, 0.5 * (opening.from + opening.to), 0.0, 0.03});
  }
}

void addFinish(Home& home, HomeRoom& room, int picture_count) {
  for (int i = 0; i < picture_count; ++i) addPicture(home, room);
  if (home.level.random.chance(0.5)) addAtWall(home, room, Use::plant, {{}, {}, 0.0, 0.05});
}

void addSeats(Home& home, HomeRoom& room, const Stood& table, Use use) {
  const std::optional<Piece> chair = drawPiece(home, use, {0.8, 0.8, 1.3});
  if (!chair) return;
  Level& level = home.level;
  const glm::dvec3& size = table.piece.size_m;
  // long sides take as many chairs as fit, 12 cm apart; the ends one each, or none
  struct Edge {
    double degrees, length, reach;
  };
  for (const Edge& edge : {Edge{0.0, size.x, size.z}, {180.0, size.x, size.z}, {90.0, size.z, size.x}, {270.0, size.z, size.x}}) {
    const bool is_end = edge.degrees == 90.0 || edge.degrees == 270.0;
    if (is_end && !level.random.chance(0.6)) continue;
    const int count = is_end ? 1 : std::max(1, static_cast<int>(edge.length / (chair->size_m.x + 0.12)));
    for (int i = 0; i < count; ++i) {
      // as people leave chairs: pulled out, turned, one in eight missing
      const double pull = level.random.chance(0.7) ? level.random.uniform(0.01, 0.08) : level.random.uniform(0.08, 0.4);
      const double turn = level.random.chance(0.5) ? 0.0 : level.random.uniform(-15.0, 15.0);
      if (level.random.chance(0.12)) continue;
      // in the table's own frame, so that seats turn with it
      const double along = edge.length * ((i + 0.5) / count - 0.5);
      const double out = 0.5 * edge.reach + 0.5 * chair->size_m.z + pull;
      Placement frame = table.placement;
      frame.turn = turnByDegrees(table.degrees + edge.degrees);
      const glm::dvec3 at = frame.apply({along, 0.0, out});
      standFree(home, room, *chair, {at.x, at.z}, table.degrees + edge.degrees + 180.0 + turn);
    }
  }
}

// A desk at a wall with what lies on it and a chair before it.
void addDesk(Home& home, HomeRoom& room, int thing_count) {
  const std::optional<Piece> desk = drawPiece(home, Use::desk, {2.2, 1.0, room.clear_m});
  const std::optional<Piece> chair = drawPiece(home, Use::office_chair, {0.8, 0.8, 1.3});
  const double pull = home.level.random.uniform(0.02, 0.35), turn = home.level.random.uniform(-30.0, 30.0);
  if (!desk || !chair) return;
  const size_t kept_count = room.kept.size();
  const std::optional<Stood> stood = standAtWall(home, room, *desk, {{}, {}, 0.95, 0.03});
  if (!stood) return;
  putOnTop(home, stood, {Use::computer, Use::table_lamp, Use::small_thing}, thing_count);
  // the chair is what the place before the desk was kept for
  room.kept.resize(kept_count);
  const glm::dvec3 seat = stood->placement.apply({0.0, 0.0, 0.5 * desk->size_m.z + 0.55 * chair->size_m.z + pull});
  standFree(home, room, *chair, {seat.x, seat.z}, stood->degrees + 180.0 + turn);
}

// A table with chairs all around, somewhere in the room, with a lamp above; none when there is no place.
void addTableGroup(Home& home, HomeRoom& room, double most_length_m) {
  Level& level = home.level;
  const std::optional<Piece> table = drawPiece(home, Use::dining_table, {most_length_m, 1.4, 1.0});
  if (!table) return;
  // the middle of the room first, then anywhere that leaves seats their room
  for (int attempt = 0; attempt < 24; ++attempt) {
    const double x_share = level.random.uniform(), z_share = level.random.uniform();
    const bool is_turned = level.random.chance(0.5);
    const double degrees = is_turned ? 90.0 : 0.0;
    const Rect area = footprint(*table, {0.0, 0.0}, degrees);
    constexpr double kSeat = 0.65;
    const Rect& f = room.floor;
    const double x_slack = f.width() - area.width() - 2.0 * kSeat, z_slack = f.depth() - area.depth() - 2.0 * kSeat;
    if (x_slack < 0.0 || z_slack < 0.0) continue;
    const bool is_middle = attempt < 2;
    const glm::dvec2 middle{f.x0 + kSeat + 0.5 * area.width() + x_slack * (is_middle ? 0.5 : x_share),
                            f.z0 + kSeat + 0.5 * area.depth() + z_slack * (is_middle ? 0.5 : z_share)};
    const std::optional<Stood> stood = standFree(home, room, *table, middle, degrees, kSeat - 0.05);
    if (!stood) continue;
    addSeats(home, room, *stood, level.random.chance(0.15) && room.use == HomeUse::meeting ? Use::office_chair : Use::chair);
    putOnTop(home, stood, {Use::kitchen_thing, Use::small_plant, Use::kitchen_thing, Use::small_thing}, level.pickCount(0, 6));
    return hangLamp(home, room, middle);
  }
}

// Two rows of desks back to back with a low partition of 2 to 4 cm between, chairs and computers; per_row desks in each.
// It stands within 2 m of the wanted middle, where it is free; or not at all.
void addDeskIsland(Home& home, HomeRoom& room, const glm::dvec2& wanted, bool along_x, int per_row) {
  Level& level = home.level;
  const std::optional<Piece> desk = drawPiece(home, Use::desk, {1.8, 0.95, 1.0});
  if (!desk) return;
  // two rows of desks face each other over a partition, as one piece whose place is sought
  const double partition = level.pick(0.0, 0.05) * 0.4 + 0.02;  // 2, 3 or 4 cm
  const double height = level.pick(1.15, 1.6);
  const double degrees = along_x ? 0.0 : 90.0;
  const double length = per_row * (desk->size_m.x + 0.02);
  const Piece screen{Use::none, {length, height, partition}, 0.0, 0.0, nullptr, "partition"};
  const Piece island{Use::none, {length, height, 2.0 * desk->size_m.z + partition + 0.02}, 0.0, 0.0, nullptr, "island"};
  // round columns, walls and each other
  glm::dvec2 middle = wanted;
  bool is_free = false;
  for (int attempt = 0; attempt < 30 && !is_free; ++attempt) {
    const Rect area = footprint(island, middle, degrees);
    // the chairs' places as well
    const double x = along_x ? 0.2 : 0.85, z = along_x ? 0.85 : 0.2;
    const Rect with_seats{area.x0 - x, area.z0 - z, area.x1 + x, area.z1 + z};
    is_free = room.isFree({area, room.floor_m, room.floor_m + height}) &&
              room.isEmpty({with_seats, room.floor_m, room.floor_m + height}) && with_seats.x0 >= room.floor.x0 &&
              with_seats.x1 <= room.floor.x1 && with_seats.z0 >= room.floor.z0 && with_seats.z1 <= room.floor.z1;
    if (!is_free) middle = wanted + glm::dvec2{level.random.uniform(-2.0, 2.0), level.random.uniform(-2.0, 2.0)};
  }
  if (!is_free) return;
  const Placement frame{{middle.x, room.floor_m, middle.y}, turnByDegrees(degrees)};
  // one island in five has no partition: rows see each other
  if (level.random.chance(0.8)) {
    room.solids.push_back({footprint(screen, middle, degrees), room.floor_m, room.floor_m + height});
    level.mesh.beginObject("partition", Mobility::movable);
    addBox(level.mesh, frame, {-0.5 * length, 0.0, -0.5 * partition}, {0.5 * length, height, 0.5 * partition},
           level.palette.cloth);
  }
  // desks and chairs in the island's frame; a chair may stand off its desk, turned, or be missing
  for (const double row : {-1.0, 1.0}) {
    for (int i = 0; i < per_row; ++i) {
      const double along = length * ((i + 0.5) / per_row - 0.5);
      const glm::dvec3 at = frame.apply({along, 0.0, row * (0.5 * partition + 0.5 * desk->size_m.z + 0.01)});
      const std::optional<Stood> stood = standFree(home, room, *desk, {at.x, at.z}, degrees + (row > 0 ? 0.0 : 180.0));
      if (!stood) continue;
      putOnTop(home, stood, {Use::computer, Use::computer, Use::small_thing, Use::table_lamp}, 2);
      const std::optional<Piece> chair = drawPiece(home, Use::office_chair, {0.8, 0.8, 1.3});
      const double pull = level.random.uniform(0.02, 0.4), turn = level.random.uniform(-40.0, 40.0);
      if (!chair || level.random.chance(0.1)) continue;
      const glm::dvec3 seat = stood->placement.apply({0.0, 0.0, 0.5 * desk->size_m.z + 0.55 * chair->size_m.z + 0.1 + pull});
      standFree(home, room, *chair, {seat.x, seat.z}, stood->degrees + 180.0 + turn);
    }
  }
}

// People and animals that stand about.
void addPeople(Home& home, HomeRoom& room, int count) {
  for (int i = 0; i < count; ++i) {
    const Use use = home.level.random.chance(0.85) ? Use::person : Use::animal;
    addAnywhere(home, room, use, {1.2, 1.2, 2.0}, 0.1);
  }
}

void furnishBedroom(Home& home, HomeRoom& room) {
  Level& level = home.level;
  const bool is_child = room.use == HomeUse::child;
  addCurtainsOf(home, room, 0.7);
  // the bed first: what stands beside it, and what must not stand before it, follows from its place
  const std::optional<Stood> bed = addAtWall(home, room, is_child ? Use::child_bed : Use::bed, {{}, {}, 0.5, 0.03});
  if (bed) {
    const std::optional<Piece> bedside = drawPiece(home, Use::bedside, {0.7, 0.6, 0.9});
    const glm::dvec2 middle = bed->area.middle();
    const double along = alongX(bed->wall) ? middle.x : middle.y;
    for (const double sign : {-1.0, 1.0}) {
      if (!bedside || !level.random.chance(0.85)) continue;
      const double at = along + sign * (0.5 * (bed->piece.size_m.x + bedside->size_m.x) + 0.04);
      putOnTop(home, standAtWall(home, room, *bedside, {bed->wall, at, 0.0, 0.02}),
               {Use::table_lamp, Use::table_lamp, Use::small_thing}, 1);
    }
    addRug(home, room, middle + glm::dvec2(0.4, 0.3), bed->degrees);
  }
  // large pieces before small ones: later pieces take the wall that is left
  addAtWall(home, room, Use::wardrobe, {{}, {}, 0.6, 0.02});
  if (level.random.chance(is_child ? 0.8 : 0.4)) addDesk(home, room, 2);
  for (int i = level.pickCount(1, 2); i > 0; --i)
    putOnTop(home, addAtWall(home, room, Use::chest), {Use::small_thing, Use::small_plant, Use::table_lamp}, 3);
  if (level.random.chance(is_child ? 0.9 : 0.5)) addAtWall(home, room, Use::bookcase, {{}, {}, 0.4, 0.02});
  if (level.random.chance(0.3)) addAtWall(home, room, Use::storage, {{}, {}, 0.0, 0.03});
  if (level.random.chance(0.3)) addAtWall(home, room, Use::floor_lamp, {{}, {}, 0.0, 0.05});
  for (int i = 0; i < 2 && is_child; ++i) addAnywhere(home, room, Use::toy, {}, 0.1);
  if (!is_child && level.random.chance(0.3)) addAtWall(home, room, Use::armchair, {{}, {}, 0.4, 0.08});
  // last what has a place of its own: radiators below windows, the lamp in the middle of the ceiling
  addRadiators(home, room);
  addFinish(home, room, level.pickCount(0, 2));
  hangLamp(home, room, room.floor.middle());
}

// Where a screen and the seats that face it stand, across the room.
struct ScreenFacing {
  Side tv_wall = Side::north;
  double along = 0.0, distance = 0.0;
};

// A place for a sofa opposite a place for a screen, both free.
std::optional<ScreenFacing> drawFacing(Home& home, const HomeRoom& room, const Piece& sofa) {
  Random& random = home.level.random;
  for (int attempt = 0; attempt < 60; ++attempt) {
    const Side wall = kSides[random.below(4)];
    const double along = room.floor.start(wall) + room.floor.length(wall) * random.uniform(0.25, 0.75);
    const double depth = alongX(wall) ? room.floor.depth() : room.floor.width();
    const double distance = std::min(random.uniform(2.3, 3.2), depth - sofa.size_m.z - 0.06);
    if (distance < 1.6) continue;
    const Placement frame = onWall(room, wall, along, room.floor_m);
    const glm::dvec3 seat = frame.apply({0.0, 0.0, distance + 0.5 * sofa.size_m.z}), screen = frame.apply({0.0, 0.0, 0.25});
    const Rect seat_area = footprint(sofa, {seat.x, seat.z}, degreesAt(wall));
    const Rect screen_area = Rect{screen.x, screen.z, screen.x, screen.z}.grown(0.24);
    if (room.isFree({seat_area, room.floor_m, room.floor_m + 0.9}) &&
        room.isFree({screen_area, room.floor_m, room.floor_m + 0.6}))
      return ScreenFacing{wall, along, distance};
  }
  return std::nullopt;
}

void addScreen(Home& home, HomeRoom& room, const ScreenFacing& facing) {
  const std::optional<Piece> stand = drawPiece(home, Use::tv_stand, {2.0, 0.75, 0.8});
  const std::optional<Piece> tv = drawPiece(home, Use::tv, {1.6, 0.5, 1.2}),
                             flat = drawPiece(home, Use::wall_tv, {2.0, 0.4, 2.2});
  const bool is_on_wall = flat && (!tv || home.level.random.chance(0.5));
  const std::optional<Stood> stood =
      stand ? standAtWall(home, room, *stand, {facing.tv_wall, facing.along, 0.4, 0.03}) : std::nullopt;
  if (is_on_wall) {
    standAtWall(home, room, *flat, {facing.tv_wall, facing.along, 0.0, 0.005});
  } else if (stood && tv && stood->piece.top_m > 0.0) {
    Placement on = stood->placement;
    on.position.y += stood->piece.top_m;
    emitPiece(home, *tv, on);
  }
}

// The sofa faces a screen over a low table, armchairs at its sides.
void addSeatingGroup(Home& home, HomeRoom& room) {
  Level& level = home.level;
  const std::optional<Piece> large = level.random.chance(0.3) ? drawPiece(home, Use::corner_sofa, {3.2, 2.0, 1.4}) : std::nullopt;
  const std::optional<Piece> found = large ? large : drawPiece(home, Use::sofa, {3.0, 1.3, 1.4});
  if (!found) return;
  // the sofa looks at a screen across the room; where no wall allows that, it stands at a wall alone
  const std::optional<ScreenFacing> facing = drawFacing(home, room, *found);
  std::optional<Stood> seat;
  if (facing) {
    const Placement frame = onWall(room, facing->tv_wall, facing->along, room.floor_m);
    const glm::dvec3 at = frame.apply({0.0, 0.0, facing->distance + 0.5 * found->size_m.z});
    seat = standFree(home, room, *found, {at.x, at.z}, degreesAt(opposite(facing->tv_wall)));
    addScreen(home, room, *facing);
  }
  if (!seat) seat = standAtWall(home, room, *found, {{}, {}, 0.3, 0.05});
  if (!seat) return;
  Placement before = seat->placement;
  before.turn = turnByDegrees(seat->degrees);
  const std::optional<Piece> table = drawPiece(home, Use::coffee_table, {1.5, 0.9, 0.6});
  if (table) {
    const glm::dvec3 at = before.apply({0.0, 0.0, 0.5 * found->size_m.z + 0.35 + 0.5 * table->size_m.z});
    addRug(home, room, {at.x, at.z}, seat->degrees);
    putOnTop(home, standFree(home, room, *table, {at.x, at.z}, seat->degrees),
             {Use::small_thing, Use::small_plant, Use::kitchen_thing}, 2);
  }
  // armchairs at the ends of the table, facing each other
  const std::optional<Piece> armchair = drawPiece(home, Use::armchair, {1.2, 1.2, 1.3});
  for (const double sign : {-1.0, 1.0}) {
    if (!armchair || !level.random.chance(0.6)) continue;
    const double turn = level.random.uniform(-20.0, 20.0);
    const glm::dvec3 at = before.apply({sign * (0.5 * found->size_m.x + 0.55), 0.0, 0.5 * found->size_m.z + 0.75});
    standFree(home, room, *armchair, {at.x, at.z}, seat->degrees - sign * 90.0 + turn, 0.1);
  }
  // a side table with a lamp, or a floor lamp, at one arm
  const std::optional<Piece> side =
      drawPiece(home, level.random.chance(0.5) ? Use::side_table : Use::floor_lamp, {0.7, 0.7, 2.0});
  if (!side) return;
  const glm::dvec3 at = before.apply({0.5 * (found->size_m.x + side->size_m.x) + 0.08, 0.0, 0.0});
  const std::optional<Stood> stood = standFree(home, room, *side, {at.x, at.z}, seat->degrees);
  if (side->use == Use::side_table) putOnTop(home, stood, {Use::table_lamp, Use::small_plant}, 1);
}

void furnishLiving(Home& home, HomeRoom& room) {
  Level& level = home.level;
  addCurtainsOf(home, room, 0.7);
  if (level.random.chance(0.3)) addAtWall(home, room, Use::fireplace, {{}, {}, 0.8, 0.0});
  addSeatingGroup(home, room);
  if (room.floor.width() * room.floor.depth() > 22.0) addTableGroup(home, room, 2.4);
  for (int i = level.pickCount(1, 3); i > 0; --i) {
    const std::optional<Stood> shelf = addAtWall(home, room, Use::bookcase, {{}, {}, 0.4, 0.02});
    if (shelf && shelf->piece.size_m.y < 1.3) putOnTop(home, shelf, {Use::small_plant, Use::small_thing}, 2);
  }
  if (level.random.chance(0.25)) addAtWall(home, room, Use::piano, {{}, {}, 0.7, 0.05});
  putOnTop(home, addAtWall(home, room, Use::chest), {Use::small_thing, Use::small_plant, Use::table_lamp}, 3);
  addAtWall(home, room, Use::plant, {{}, {}, 0.0, 0.05});
  if (level.random.chance(0.5)) addAtWall(home, room, Use::floor_lamp, {{}, {}, 0.0, 0.1});
  addRadiators(home, room);
  addFinish(home, room, level.pickCount(1, 4));
  hangLamp(home, room, room.floor.middle());
  if (level.random.chance(0.4)) addPeople(home, room, 1);
}

void furnishDining(Home& home, HomeRoom& room) {
  Level& level = home.level;
  addCurtainsOf(home, room, 0.6);
  addTableGroup(home, room, 2.4);
  putOnTop(home, addAtWall(home, room, Use::chest), {Use::small_thing, Use::small_plant, Use::kitchen_thing}, 3);
  if (level.random.chance(0.6)) addAtWall(home, room, Use::bookcase, {{}, {}, 0.4, 0.02});
  addRadiators(home, room);
  addFinish(home, room, level.pickCount(1, 3));
  if (level.random.chance(0.3)) addPeople(home, room, 1);
}

// A row of units along a wall, from one corner on, with units above them.
void addKitchenRow(Home& home, HomeRoom& room, Side side, const std::vector<Use>& row) {
  constexpr double kStep = 0.08, kGap = 0.01;
  Level& level = home.level;
  // one model for all base units of a row, one for those above
  const std::optional<Piece> base = drawPiece(home, Use::kitchen_base, {1.2, 0.8, 1.2});
  const std::optional<Piece> above = drawPiece(home, Use::kitchen_wall, {1.2, 0.6, room.clear_m});
  const bool has_above = level.random.chance(0.85);
  double at = room.floor.start(side) + kGap;
  const double end = room.floor.start(side) + room.floor.length(side) - kGap;
  for (const Use use : row) {
    const std::optional<Piece> piece = use == Use::kitchen_base ? base : drawPiece(home, use, {1.2, 1.0, room.clear_m});
    if (!piece) continue;
    std::optional<Stood> stood;
    // slides along the wall past doors and windows, 8 cm a step, until the unit fits
    for (; !stood && at + piece->size_m.x <= end; at += stood ? piece->size_m.x + 0.002 : kStep) {
      const double middle = at + 0.5 * piece->size_m.x;
      const Rect area = room.floor.strip(side, at, at + piece->size_m.x, piece->size_m.z + kGap);
      if (!room.isFree({area, room.floor_m + piece->elevation_m, room.floor_m + piece->elevation_m + piece->size_m.y})) continue;
      stood = standAtWall(home, room, *piece, {side, middle, 0.0, kGap});
      if (!stood) break;
    }
    // the wall is full: the row ends
    if (!stood) return;
    const double middle = at - 0.002 - 0.5 * piece->size_m.x;
    // 90 cm before a unit stay free, to stand at it
    room.kept.push_back(
        {room.floor.strip(side, middle - 0.5 * piece->size_m.x, middle + 0.5 * piece->size_m.x, piece->size_m.z + 0.9),
         room.floor_m, room.floor_m + 1.2});
    // a tall unit takes the place of those above
    if (piece->size_m.y > 1.1) continue;
    if (use == Use::kitchen_base) putOnTop(home, stood, {Use::kitchen_thing}, level.pickCount(0, 2));
    // the lower edge of a hood is 1.55 m above the floor
    const std::optional<Piece> hood = use == Use::cooker ? drawPiece(home, Use::hood, {1.2, 0.6, 0.6}) : std::nullopt;
    if (hood) {
      Piece raised = *hood;
      raised.elevation_m = 1.55;
      standAtWall(home, room, raised, {side, middle, 0.0, kGap});
    } else if (has_above && above) {
      standAtWall(home, room, *above, {side, middle, 0.0, kGap});
    }
  }
}

void furnishKitchen(Home& home, HomeRoom& room) {
  Level& level = home.level;
  std::vector<Side> sides = {Side::north, Side::west, Side::south, Side::east};
  // the row stands at a wall with few doors
  std::stable_sort(sides.begin(), sides.end(), [&](Side a, Side b) {
    const auto cost = [&](Side side) {
      double free_m = room.floor.length(side);
      for (const RoomOpening& o : room.openings) {
        if (o.side == side) free_m -= (o.kind == RoomOpening::Kind::window ? 0.3 : 1.3) * (o.to - o.from);
      }
      return -free_m;
    };
    return cost(a) < cost(b);
  });
  // cold, wash, cook: the order of a kitchen's work, with worktop between
  addKitchenRow(home, room, sides[0],
                {Use::fridge, Use::kitchen_base, Use::kitchen_sink, Use::kitchen_base, Use::cooker, Use::kitchen_base,
                 Use::kitchen_base, Use::kitchen_base});
  // a second row along the wall with the next most room
  if (level.random.chance(0.5))
    addKitchenRow(home, room, sides[1], {Use::kitchen_base, Use::laundry, Use::kitchen_base, Use::kitchen_base});
  const double area = room.floor.width() * room.floor.depth();
  // an island only in large kitchens: the way around it takes .8 m
  if (area > 16.0 && level.random.chance(0.5)) {
    const std::optional<Piece> island = drawPiece(home, Use::island, {1.6, 1.3, 1.2});
    const std::optional<Stood> stood = island ? standFree(home, room, *island, room.floor.middle(), 0.0, 0.8) : std::nullopt;
    if (stood) addSeats(home, room, *stood, Use::bar_stool);
  }
  addCurtainsOf(home, room, 0.3);
  addTableGroup(home, room, area > 14.0 ? 2.0 : 1.3);
  addRadiators(home, room);
  addFinish(home, room, level.pickCount(0, 1));
  hangLamp(home, room, room.floor.middle());
  if (level.random.chance(0.3)) addPeople(home, room, 1);
}

void furnishBath(Home& home, HomeRoom& room) {
  Level& level = home.level;
  // what is largest goes into a corner first
  const bool has_bath = room.use == HomeUse::bath && level.random.chance(0.75);
  if (has_bath) {
    const std::optional<Piece> bath = drawPiece(home, Use::bath, {2.0, 1.7, 1.3});
    const uint32_t first = level.random.below(4);
    bool is_there = !bath;
    for (uint32_t i = 0; i < 4 && !is_there; ++i) {
      const Side side = kSides[(first + i) % 4];
      is_there = standAtWall(home, room, *bath, {side, room.floor.start(side), 0.4, 0.01}).has_value() ||
                 standAtWall(home, room, *bath, {side, room.floor.start(side) + room.floor.length(side), 0.4, 0.01}).has_value();
    }
  }
  // toilet and basin in toilets and baths alike, the rest in baths
  addAtWall(home, room, Use::toilet, {{}, {}, 0.4, 0.01});
  addAtWall(home, room, Use::washbasin, {room.use == HomeUse::bath ? 1.3 : 0.65, 0.8, 2.3}, {{}, {}, 0.4, 0.01});
  if (room.use == HomeUse::bath) {
    if (!has_bath || level.random.chance(0.4)) addAtWall(home, room, Use::shower, {{}, {}, 0.4, 0.01});
    if (level.random.chance(0.5)) addAtWall(home, room, Use::laundry, {{}, {}, 0.5, 0.02});
    if (level.random.chance(0.6)) addAtWall(home, room, Use::radiator, {{}, {}, 0.2, 0.02});
    if (level.random.chance(0.5)) addAtWall(home, room, Use::storage, {{}, {}, 0.0, 0.03});
    addAtWall(home, room, Use::wall_thing, {{}, {}, 0.0, 0.005});
    addRug(home, room, room.floor.middle(), 0.0);
  }
  addPicture(home, room);
  hangLamp(home, room, room.floor.middle());
}

void furnishStudy(Home& home, HomeRoom& room) {
  Level& level = home.level;
  addCurtainsOf(home, room, 0.4);
  addDesk(home, room, 3);
  for (int i = level.pickCount(1, 3); i > 0; --i) addAtWall(home, room, Use::bookcase, {{}, {}, 0.4, 0.02});
  addAtWall(home, room, Use::filing, {{}, {}, 0.4, 0.02});
  if (level.random.chance(0.5)) addAtWall(home, room, Use::armchair, {{}, {}, 0.4, 0.1});
  if (level.random.chance(0.3)) addAtWall(home, room, Use::storage, {{}, {}, 0.0, 0.03});
  if (level.random.chance(0.2)) addAtWall(home, room, Use::piano, {{}, {}, 0.6, 0.05});
  addRadiators(home, room);
  addFinish(home, room, level.pickCount(0, 2));
  hangLamp(home, room, room.floor.middle());
}

void furnishHall(Home& home, HomeRoom& room) {
  Level& level = home.level;
  const double narrow = std::min(room.floor.width(), room.floor.depth());
  const double deepest = std::max(0.2, narrow - 0.95);  // people still pass
  for (const Use use : {Use::chest, Use::bookcase}) {
    if (!level.random.chance(0.6)) continue;
    const std::optional<Stood> stood = addAtWall(home, room, use, {2.0, deepest, room.clear_m}, {{}, {}, 0.85, 0.01});
    if (use == Use::chest) putOnTop(home, stood, {Use::table_lamp, Use::small_plant, Use::small_thing}, 2);
  }
  for (int i = level.pickCount(0, 3); i > 0; --i) addPicture(home, room);
  if (narrow > 1.4 && level.random.chance(0.4)) addAtWall(home, room, Use::plant, {{}, {}, 0.7, 0.05});
  if (level.random.chance(0.5)) addAtWall(home, room, Use::wall_lamp, {{}, {}, 0.0, 0.005});
  hangLamp(home, room, room.floor.middle());
  if (level.random.chance(0.25)) addPeople(home, room, 1);
}

void furnishStore(Home& home, HomeRoom& room) {
  for (int i = 0; i < 2; ++i) addAtWall(home, room, Use::bookcase, {{}, {}, 0.3, 0.02});
  for (int i = home.level.pickCount(2, 6); i > 0; --i) addAtWall(home, room, Use::storage, {{}, {}, 0.0, 0.03});
  addAtWall(home, room, Use::laundry);
  if (home.level.random.chance(0.4)) addAtWall(home, room, Use::fitness, {{}, {}, 0.2, 0.1});
  hangLamp(home, room, room.floor.middle());
}

// Below slopes: nothing hangs on walls, and what stands is low.
void furnishAttic(Home& home, HomeRoom& room) {
  Level& level = home.level;
  addAtWall(home, room, level.random.chance(0.5) ? Use::bed : Use::child_bed, {{}, {}, 0.5, 0.05});
  addDesk(home, room, 2);
  for (const Use use : {Use::chest, Use::bookcase, Use::armchair, Use::chest, Use::plant, Use::fitness}) {
    const std::optional<Piece> piece = drawPiece(home, use, {2.0, 1.2, std::min(1.4, room.clear_m)});
    if (piece && level.random.chance(0.6)) standAtWall(home, room, *piece, {{}, {}, 0.5, 0.05});
  }
  for (int i = level.pickCount(2, 5); i > 0; --i) addAtWall(home, room, Use::storage, {{}, {}, 0.0, 0.03});
  addRug(home, room, room.floor.middle(), 0.0);
}

void furnishMeeting(Home& home, HomeRoom& room) {
  addTableGroup(home, room, 3.0);
  addAtWall(home, room, Use::board, {{}, {}, 0.3, 0.05});
  addAtWall(home, room, Use::wall_tv, {2.0, 0.4, 2.2}, {{}, {}, 0.0, 0.005});
  addFinish(home, room, 1);
  if (home.level.random.chance(0.4)) addPeople(home, room, 1);
}

void furnishLounge(Home& home, HomeRoom& room) {
  addSeatingGroup(home, room);
  addAtWall(home, room, Use::bookcase, {{}, {}, 0.4, 0.02});
  if (home.level.random.chance(0.5)) addAnywhere(home, room, Use::game, {3.0, 2.0, 1.2}, 0.7);
  addFinish(home, room, 2);
  addFinish(home, room, 0);
  hangLamp(home, room, room.floor.middle());
  addPeople(home, room, home.level.pickCount(0, 2));
}

void furnishOpenOffice(Home& home, HomeRoom& room) {
  Level& level = home.level;
  // a grid of desk islands, the way between rows included in its step; one in twelve stays empty
  const bool along_x = level.random.chance(0.5);
  const int per_row = level.pickCount(2, 3);
  const double along = 1.7 * per_row + level.pick(1.4, 2.2), across = level.pick(4.4, 5.4);
  const double x_step = along_x ? along : across, z_step = along_x ? across : along;
  for (double x = room.floor.x0 + 0.5 * x_step; x < room.floor.x1; x += x_step) {
    for (double z = room.floor.z0 + 0.5 * z_step; z < room.floor.z1; z += z_step) {
      if (!level.random.chance(0.08)) addDeskIsland(home, room, {x, z}, along_x, per_row);
    }
  }
  // storage and plants along the walls
  for (int i = level.pickCount(3, 6); i > 0; --i) addAtWall(home, room, Use::bookcase, {{}, {}, 0.7, 0.02});
  for (int i = level.pickCount(2, 5); i > 0; --i) addAtWall(home, room, Use::filing, {{}, {}, 0.6, 0.02});
  for (int i = level.pickCount(3, 7); i > 0; --i) addAtWall(home, room, Use::plant, {{}, {}, 0.0, 0.05});
  addAtWall(home, room, Use::cooler, {{}, {}, 0.5, 0.03});
  addAtWall(home, room, Use::board, {{}, {}, 0.5, 0.05});
  addRadiators(home, room);
  for (int i = level.pickCount(1, 4); i > 0; --i) addPicture(home, room);
  // lamps on a grid of 3.5 m, whatever stands below
  for (double x = room.floor.x0 + 2.0; x < room.floor.x1 - 1.0; x += 3.5) {
    for (double z = room.floor.z0 + 2.0; z < room.floor.z1 - 1.0; z += 3.5) hangLamp(home, room, {x, z});
  }
  addPeople(home, room, level.pickCount(1, 4));
}

void furnishSalon(Home& home, HomeRoom& room) {
  Level& level = home.level;
  addCurtainsOf(home, room, 0.4);
  if (level.random.chance(0.6)) addAtWall(home, room, Use::fireplace, {{}, {}, 1.0, 0.0});
  for (int i = level.pickCount(2, 3); i > 0; --i) addSeatingGroup(home, room);
  addTableGroup(home, room, 2.6);
  if (level.random.chance(0.6)) addAnywhere(home, room, Use::piano, {2.0, 2.0, 2.0}, 0.6);
  if (level.random.chance(0.4)) addAnywhere(home, room, Use::game, {3.0, 2.0, 1.2}, 0.8);
  for (int i = level.pickCount(2, 5); i > 0; --i) addAtWall(home, room, Use::plant, {{}, {}, 0.0, 0.1});
  for (const Use use : {Use::bookcase, Use::chest, Use::bookcase, Use::armchair, Use::floor_lamp, Use::chest, Use::armchair}) {
    if (level.random.chance(0.8)) addAtWall(home, room, use, {{}, {}, 0.5, 0.03});
  }
  addFinish(home, room, level.pickCount(2, 5));
  addPeople(home, room, level.pickCount(0, 3));
}

// Of the library, or, where it has none, a procedural one.
void addGardenTree(Home& home, HomeRoom& room) {
  const std::optional<Piece> piece = drawPiece(home, Use::tree, {8.5, 8.5, 12.0});
  if (piece) {
    standAnywhere(home, room, *piece, 0.1);
    return;
  }
  Random& random = home.level.random;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const glm::dvec2 at{random.uniform(room.floor.x0, room.floor.x1), random.uniform(room.floor.z0, room.floor.z1)};
    const Box box{Rect{at.x, at.y, at.x, at.y}.grown(1.6), room.floor_m, room.floor_m + 6.0};
    if (!room.isFree(box)) continue;
    room.solids.push_back(box);
    return addTree(home.level, {at.x, room.floor_m, at.y});
  }
}

void furnishTerrace(Home& home, HomeRoom& room) {
  Level& level = home.level;
  const auto scatter = [&](Use use, int count, double margin) {
    for (int i = 0; i < count; ++i) addAnywhere(home, room, use, {9.0, 9.0, 12.0}, margin);
  };
  const std::optional<Piece> table = drawPiece(home, Use::garden_table, {2.2, 2.2, 1.2});
  if (table) {
    const double degrees = 90.0 * level.pickCount(0, 3);
    const std::optional<Stood> stood = standFree(home, room, *table, room.floor.middle(), degrees, 0.5);
    if (stood) addSeats(home, room, *stood, level.random.chance(0.5) ? Use::garden_seat : Use::chair);
  }
  for (int i = level.pickCount(2, 5); i > 0; --i) addGardenTree(home, room);
  scatter(Use::hedge, level.pickCount(2, 6), 0.1);
  scatter(Use::garden_seat, level.pickCount(1, 3), 0.3);
  scatter(Use::garden_thing, level.pickCount(1, 4), 0.2);
  addPeople(home, room, level.pickCount(0, 2));
}

}  // namespace

void furnish(Home& home, HomeRoom& room) {
  // in the order of HomeUse
  constexpr void (*kRecipes[])(Home&, HomeRoom&) = {
      furnishLiving,  furnishDining, furnishKitchen, furnishBedroom, furnishBedroom, furnishBath,
      furnishBath,    furnishStudy,  furnishHall,    furnishStore,   furnishAttic,   furnishOpenOffice,
      furnishMeeting, furnishLounge, furnishKitchen, furnishHall,    furnishSalon,   furnishTerrace};
  kRecipes[static_cast<size_t>(room.use)](home, room);
}

}  // namespace nlg
