#include "scene/interiors/room.h"

#include <algorithm>

namespace nlg {

bool HomeRoom::hasWall(Side side) const { return std::find(open_sides.begin(), open_sides.end(), side) == open_sides.end(); }

Rect HomeRoom::strip(Side side, double from, double to, double depth) const {
  switch (side) {
    case Side::north:
      return {from, floor.z0, to, floor.z0 + depth};
    case Side::south:
      return {from, floor.z1 - depth, to, floor.z1};
    case Side::west:
      return {floor.x0, from, floor.x0 + depth, to};
    default:
      return {floor.x1 - depth, from, floor.x1, to};
  }
}

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

double degreesAt(Side wall) {
  switch (wall) {
    case Side::north:
      return 0.0;
    case Side::west:
      return 90.0;
    case Side::south:
      return 180.0;
    default:
      return 270.0;
  }
}

Side opposite(Side side) {
  switch (side) {
    case Side::north:
      return Side::south;
    case Side::south:
      return Side::north;
    case Side::west:
      return Side::east;
    default:
      return Side::west;
  }
}

bool alongX(Side side) { return side == Side::north || side == Side::south; }

}  // namespace nlg
