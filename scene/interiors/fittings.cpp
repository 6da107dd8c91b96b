#include "scene/interiors/fittings.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

// How far a leaf is open.
double drawLeafDegrees(Level& level) {
  const double kind = level.random.uniform();
  if (kind < 0.12) return 0.0;
  return kind < 0.35 ? level.random.uniform(8.0, 60.0) : level.random.uniform(60.0, 110.0);
}

// A sheet in pleats along local x, on the wall's face.
void addPleats(Home& home, const Placement& wall, double from, double to, double height, double depth) {
  constexpr double kPleat = 0.09;
  const int count = std::max(2, static_cast<int>((to - from) / kPleat));
  MeshBuilder& mesh = home.level.mesh;
  mesh.beginObject("curtain", Mobility::movable);
  uint32_t low = 0, high = 0;
  for (int i = 0; i <= count; ++i) {
    const double x = from + (to - from) * i / count;
    const double z = depth + (i % 2 == 0 ? -0.03 : 0.03);
    const uint32_t next_low = mesh.addVertex(wall, {x, 0.0, z}), next_high = mesh.addVertex(wall, {x, height, z});
    if (i > 0) mesh.addQuad(low, next_low, next_high, high, home.curtain_material);
    low = next_low;
    high = next_high;
  }
}

}  // namespace

Placement onWall(const HomeRoom& room, Side side, double along, double y) {
  const double edge = room.floor.edge(side);
  return {alongX(side) ? glm::dvec3(along, y, edge) : glm::dvec3(edge, y, along), turnByDegrees(degreesAt(side))};
}

void addLeaf(Home& home, HomeRoom& room, const RoomOpening& opening) {
  constexpr double kThick = 0.04, kGap = 0.012;
  Level& level = home.level;
  const double width = opening.to - opening.from;
  const bool hinge_at_from = level.random.chance(0.5);
  double degrees = drawLeafDegrees(level);
  // beyond a right angle the leaf comes nearer to the wall beside the doorway
  const double end = room.floor.start(opening.side) + room.floor.length(opening.side);
  const double beside = hinge_at_from ? opening.from - room.floor.start(opening.side) : end - opening.to;
  if (beside < 0.5 * width) degrees = std::min(degrees, 88.0);
  // local x of the wall runs along +x at the north, along -z at the west, and so on
  const bool along_rises = opening.side == Side::north || opening.side == Side::east;
  const bool x_rises_from_hinge = hinge_at_from == along_rises;
  const double sign = x_rises_from_hinge ? 1.0 : -1.0;
  Placement hinge = onWall(room, opening.side, hinge_at_from ? opening.from : opening.to, opening.low);
  // from the closed leaf, which lies along the wall, towards the room's inside (+z)
  hinge.turn = turnByDegrees(degreesAt(opening.side) - sign * degrees);
  BrushGrid leaf;
  const double from = sign > 0 ? kGap : -width + kGap, to = sign > 0 ? width - kGap : -kGap;
  const double height = opening.high - opening.low - kGap;
  leaf.fill({from, kGap, -kThick}, {to, height, 0.0}, level.palette.wood);
  const double knob = sign > 0 ? to - 0.08 : from + 0.08;
  leaf.fill({knob - 0.02, 0.98, -kThick - 0.05}, {knob + 0.02, 1.02, 0.05}, level.palette.metal);
  leaf.emitObject(level.mesh, "door", Mobility::movable, hinge);
  const glm::dvec3 a = hinge.apply({from, 0, 0}), b = hinge.apply({to, 0, 0});
  const Rect swept{std::min(a.x, b.x), std::min(a.z, b.z), std::max(a.x, b.x), std::max(a.z, b.z)};
  room.solids.push_back({swept.grown(kThick), opening.low, opening.high});
}

void addWindowFrame(Home& home, const HomeRoom& room, const RoomOpening& opening) {
  constexpr double kBar = 0.05;
  Level& level = home.level;
  const double half = 0.5 * (opening.to - opening.from), height = opening.high - opening.low;
  const double back = -0.5 * home.outer_wall_m - 0.03, front = back + 0.06;
  BrushGrid frame;
  frame.fill({-half, 0, back}, {half, height, front}, level.palette.wood);
  const bool has_post = half > 0.5, has_rail = level.random.chance(0.4);
  const double rail = has_rail ? height * level.random.uniform(0.6, 0.75) : height - kBar;
  for (const bool is_left : {true, false}) {
    if (!is_left && !has_post) continue;
    const double from = is_left ? -half + kBar : 0.5 * kBar;
    const double to = is_left && has_post ? -0.5 * kBar : half - kBar;
    frame.carve({from, kBar, back}, {to, rail, front});
    if (has_rail) frame.carve({from, rail + kBar, back}, {to, height - kBar, front});
  }
  frame.emitObject(level.mesh, "window frame", Mobility::movable,
                   onWall(room, opening.side, 0.5 * (opening.from + opening.to), opening.low));
}

void addCurtains(Home& home, HomeRoom& room, const RoomOpening& window) {
  constexpr double kDepth = 0.07, kReach = 0.11;
  Level& level = home.level;
  const double top = std::min(room.floor_m + room.clear_m - 0.03, window.high + 0.15);
  const double bottom = level.random.chance(0.6) ? room.floor_m + 0.02 : window.low - 0.12;
  const double over = 0.15, middle = 0.5 * (window.from + window.to);
  const double low = std::max(room.floor.start(window.side) + 0.03, window.from - over);
  const double high = std::min(room.floor.start(window.side) + room.floor.length(window.side) - 0.03, window.to + over);
  const double share = level.random.chance(0.25) ? level.random.uniform(0.35, 0.5) : level.random.uniform(0.15, 0.25);
  const double width = share * (high - low);
  for (const auto& [from, to] : {std::pair(low, low + width), std::pair(high - width, high)}) {
    const Box box{room.floor.strip(window.side, from, to, kReach), bottom, top};
    if (!room.isEmpty(box)) continue;
    room.solids.push_back(box);
    const bool along_rises = window.side == Side::north || window.side == Side::east;
    const double a = from - middle, b = to - middle;
    const double x0 = along_rises ? a : -b, x1 = along_rises ? b : -a;
    addPleats(home, onWall(room, window.side, middle, bottom), x0, x1, top - bottom, kDepth);
  }
}

void addPicture(Home& home, HomeRoom& room) {
  constexpr double kThick = 0.03;
  Level& level = home.level;
  const double width = level.pick(0.3, 1.1), height = level.pick(0.3, 0.8);
  const double middle = room.floor_m + std::min(1.55, room.clear_m - 0.5 * height - 0.2);
  for (int attempt = 0; attempt < 10; ++attempt) {
    const Side side = kSides[level.random.below(4)];
    const double slack = room.floor.length(side) - width - 0.2;
    if (slack < 0.0 || !room.hasWall(side)) continue;
    const double from = room.floor.start(side) + 0.1 + slack * level.random.uniform();
    const Box box{room.floor.strip(side, from, from + width, kThick + 0.01), middle - 0.5 * height, middle + 0.5 * height};
    if (!room.isFree(box)) continue;
    room.solids.push_back(box);
    level.mesh.beginObject("picture", Mobility::movable);
    addBox(level.mesh, onWall(room, side, from + 0.5 * width, middle), {-0.5 * width, -0.5 * height, 0.004},
           {0.5 * width, 0.5 * height, kThick}, home.paper_material);
    return;
  }
}

}  // namespace nlg
