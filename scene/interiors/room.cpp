#include "scene/interiors/room.h"

#include <algorithm>

namespace nlg {

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

}  // namespace nlg
