#include "scene/interiors/home.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "scene/interiors/fittings.h"
#include "scene/interiors/furnisher.h"

namespace nlg {
namespace {

constexpr double kThickest = 0.5;    // wall that a doorway may go through
constexpr double kJamb = 0.1;        // wall that stays beside a doorway
constexpr double kBetween = 0.12;    // wall that stays between two openings
constexpr double kBeforeDoor = 0.7;  // what stays free before a doorway, where no leaf swings

// The sides on which two rooms face each other, and what of their walls does.
struct SharedWall {
  Side a = Side::north, b = Side::north;
  double from = 0.0, to = 0.0;
};

std::optional<SharedWall> facing(const Rect& a, const Rect& b) {
  const auto near = [](double low, double high) { return high >= low - 1e-9 && high - low <= kThickest; };
  const double x0 = std::max(a.x0, b.x0), x1 = std::min(a.x1, b.x1), z0 = std::max(a.z0, b.z0), z1 = std::min(a.z1, b.z1);
  if (x1 > x0 && near(a.z1, b.z0)) return SharedWall{Side::south, Side::north, x0, x1};
  if (x1 > x0 && near(b.z1, a.z0)) return SharedWall{Side::north, Side::south, x0, x1};
  if (z1 > z0 && near(a.x1, b.x0)) return SharedWall{Side::east, Side::west, z0, z1};
  if (z1 > z0 && near(b.x1, a.x0)) return SharedWall{Side::west, Side::east, z0, z1};
  return std::nullopt;
}

bool isClear(const HomeRoom& room, Side side, double from, double to, double low, double high) {
  return std::none_of(room.openings.begin(), room.openings.end(), [&](const RoomOpening& other) {
    return other.side == side && other.from < to + kBetween && from - kBetween < other.to && other.low < high && low < other.high;
  });
}

// A hole through a wall between two planes across it.
void carveHole(Home& home, Side side, double from, double to, double plane, double other_plane, double low, double high) {
  const Rect hole = Rect::across(side, from, to, plane, other_plane);
  home.shell.carve({hole.x0, low, hole.z0}, {hole.x1, high, hole.z1});
}

void keepFree(HomeRoom& room, const RoomOpening& opening, double depth) {
  const double margin = 0.03;
  room.kept.push_back(
      {room.floor.strip(opening.side, opening.from - margin, opening.to + margin, depth), opening.low, opening.high});
}

// How far behind a wall's face at that side the outside is, along x or z.
double outwards(const Home& home, Side side) {
  return side == Side::north || side == Side::west ? -home.outer_wall_m : home.outer_wall_m;
}

// Carves an opening to the outside and keeps what is before it free.
void openOutside(Home& home, HomeRoom& room, const RoomOpening& opening, double depth) {
  const double plane = room.floor.edge(opening.side);
  carveHole(home, opening.side, opening.from, opening.to, plane, plane + outwards(home, opening.side), opening.low, opening.high);
  room.openings.push_back(opening);
  keepFree(room, opening, depth);
}

}  // namespace

bool HomeRoom::hasWall(Side side) const { return std::find(open_sides.begin(), open_sides.end(), side) == open_sides.end(); }

bool HomeRoom::isEmpty(const Box& box) const {
  return std::none_of(solids.begin(), solids.end(), [&](const Box& other) { return other.overlaps(box); });
}

bool HomeRoom::isFree(const Box& box) const {
  constexpr double kRounding = 0.001;
  const Rect inner = floor.grown(kRounding);
  const bool is_inside = box.area.x0 >= inner.x0 && box.area.x1 <= inner.x1 && box.area.z0 >= inner.z0 && box.area.z1 <= inner.z1;
  const bool is_kept = std::any_of(kept.begin(), kept.end(), [&](const Box& other) { return other.overlaps(box); });
  return is_inside && !is_kept && box.high <= floor_m + clear_m + kRounding && isEmpty(box);
}

Home::Home(uint64_t seed, FurnitureLibrary& furniture) : level(seed), library(furniture) {
  const auto add = [&](const glm::vec3& colour, bool double_sided) {
    Material material;
    material.base_color = colour;
    material.double_sided = double_sided;
    return level.mesh.addMaterial(material);
  };
  glm::vec3 cloth;
  for (int channel = 0; channel < 3; ++channel) cloth[channel] = static_cast<float>(level.random.uniform(0.2, 0.8));
  curtain_material = add(cloth, true);
  glass_material = add({0.55f, 0.62f, 0.62f}, false);
  porcelain_material = add({0.8f, 0.8f, 0.78f}, false);
  paper_material = add({0.5f, 0.45f, 0.4f}, false);
}

size_t Home::addRoom(HomeUse use, const Rect& floor, double floor_m, double clear_m) {
  HomeRoom room;
  room.use = use;
  room.floor = floor;
  room.floor_m = floor_m;
  room.clear_m = clear_m;
  shell.carve({floor.x0, floor_m, floor.z0}, {floor.x1, floor_m + clear_m, floor.z1});
  rooms.push_back(room);
  return rooms.size() - 1;
}

bool Home::connect(size_t a_idx, size_t b_idx, const DoorShape& shape) {
  HomeRoom &a = rooms[a_idx], &b = rooms[b_idx];
  // the stretch of wall that both rooms share, less what the caller keeps free of doors
  std::optional<SharedWall> found = facing(a.floor, b.floor);
  if (!found) return false;
  found->from = std::max(found->from, shape.from);
  found->to = std::min(found->to, shape.to);
  if (found->to - found->from < shape.width_m + 2.0 * kJamb) return false;
  const double slack = found->to - found->from - shape.width_m - 2.0 * kJamb;
  for (int attempt = 0; attempt < 24; ++attempt) {
    // doors mostly stand near a corner: the wall beside them is of use then
    const double draw = level.random.uniform();
    const double share = draw < 0.35 ? 0.0 : draw < 0.7 ? 1.0 : level.random.uniform();
    const double from = found->from + kJamb + slack * (attempt < 8 ? share : level.random.uniform());
    const double to = from + shape.width_m;
    // the lintel is at least 10 cm high in the lower of both rooms
    const double high = a.floor_m + std::min(shape.height_m, std::min(a.clear_m, b.clear_m) - 0.1);
    // an earlier opening keeps its place; the next attempt draws another
    if (!isClear(a, found->a, from, to, a.floor_m, high) || !isClear(b, found->b, from, to, b.floor_m, high)) continue;
    carveHole(*this, found->a, from, to, a.floor.edge(found->a), b.floor.edge(found->b), a.floor_m, high);
    const auto kind = shape.has_leaf ? RoomOpening::Kind::door : RoomOpening::Kind::passage;
    a.openings.push_back({kind, found->a, from, to, a.floor_m, high});
    b.openings.push_back({kind, found->b, from, to, b.floor_m, high});
    // leaves swing out of halls into rooms, else to either side
    const bool into_b = level.random.chance(b.use == HomeUse::hall ? 0.0 : a.use == HomeUse::hall ? 1.0 : 0.5);
    const double swing = shape.has_leaf ? shape.width_m + 0.05 : kBeforeDoor;
    keepFree(a, a.openings.back(), into_b ? kBeforeDoor : swing);
    keepFree(b, b.openings.back(), into_b ? swing : kBeforeDoor);
    HomeRoom& swings_into = into_b ? b : a;
    if (shape.has_leaf) addLeaf(*this, swings_into, swings_into.openings.back());
    return true;
  }
  return false;
}

bool Home::isOutside(size_t room, Side side) const {
  const Rect& floor = rooms[room].floor;
  return std::any_of(outsides.begin(), outsides.end(), [&](const Rect& outside) {
    const glm::dvec2 middle = floor.middle();
    const bool is_within = middle.x > outside.x0 && middle.x < outside.x1 && middle.y > outside.z0 && middle.y < outside.z1;
    return is_within && std::abs(std::abs(floor.edge(side) - outside.edge(side)) - outer_wall_m) < 0.02;
  });
}

void Home::doorOutside(size_t room_idx, Side side, double at, const DoorShape& shape, bool is_front_door) {
  HomeRoom& room = rooms[room_idx];
  // a front door of the catalogue sets the size of its hole
  DoorShape fitted = shape;
  std::optional<Piece> piece;
  if (is_front_door) piece = drawPiece(*this, FurnitureUse::front_door, {1.2, 0.6, room.clear_m - 0.1});
  if (piece) fitted = {piece->size_m.x, piece->size_m.y, false};
  // a jamb of wall stays on either side
  const double from = std::clamp(
      room.floor.start(side) + at, room.floor.start(side) + kJamb,
      std::max(room.floor.start(side) + kJamb, room.floor.start(side) + room.floor.length(side) - kJamb - fitted.width_m));
  const RoomOpening opening{piece || fitted.has_leaf ? RoomOpening::Kind::door : RoomOpening::Kind::passage,
                            side,
                            from,
                            from + fitted.width_m,
                            room.floor_m,
                            room.floor_m + std::min(fitted.height_m, room.clear_m - 0.1)};
  openOutside(*this, room, opening, fitted.width_m + 0.05);
  if (fitted.has_leaf) addLeaf(*this, room, opening);
  if (!piece) return;
  // the door stands in the middle of the outer wall's thickness
  const double middle = 0.5 * (opening.from + opening.to), across = room.floor.edge(side) + 0.5 * outwards(*this, side);
  const glm::dvec3 foot = alongX(side) ? glm::dvec3(middle, opening.low, across) : glm::dvec3(across, opening.low, middle);
  emitPiece(*this, *piece, {foot, turnByDegrees(degreesAt(side))});
}

void Home::window(size_t room_idx, Side side, double from, double to, double low_m, double high_m) {
  HomeRoom& room = rooms[room_idx];
  if (!isClear(room, side, from, to, low_m, high_m)) return;
  openOutside(*this, room, {RoomOpening::Kind::window, side, from, to, low_m, high_m}, 0.25);
  addWindowFrame(*this, room, room.openings.back());
}

void Home::windows(size_t room_idx, double share, double sill_m, double head_m) {
  const double width = level.pick(0.8, 1.6);
  const double distance = width + level.pick(0.7, 1.6);
  for (const Side side : kSides) {
    if (!isOutside(room_idx, side)) continue;
    const HomeRoom& room = rooms[room_idx];
    const double length = room.floor.length(side), start = room.floor.start(side);
    const int count = std::max(1, static_cast<int>(length / distance));
    const double fitted = std::min(width, length / count - 0.4);
    for (int i = 0; i < count; ++i) {
      if (!level.random.chance(share) || fitted < 0.4) continue;
      const double middle = start + length * (i + 0.5) / count;
      const double floor_m = rooms[room_idx].floor_m;
      window(room_idx, side, middle - 0.5 * fitted, middle + 0.5 * fitted, floor_m + sill_m, floor_m + head_m);
    }
  }
}

void finishShell(Home& home) { home.shell.emitObject(home.level.mesh, "shell", Mobility::structure); }

}  // namespace nlg
