#include "scene/procedural/building.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

class Parter {
 public:
  Parter(Level& level, const Building& building, int storey, const PlanOptions& options, std::vector<Rect>& keep_free)
      : level_(level),
        floor_m_(building.floorHeight(storey)),
        clear_m_(building.clear_m[storey]),
        options_(options),
        keep_free_(keep_free) {}

  void part(const Rect& room) {
    // the wall's side: it stands between the room's half there and the other one
    const Side side = room.depth() > room.width() * level_.random.uniform(0.75, 1.33) ? Side::north : Side::west;
    const double length = alongX(side) ? room.depth() : room.width();
    const double slack = length - 2.0 * options_.min_side_m - options_.wall_m;
    if (slack < 0.0 || (level_.random.chance(options_.stop_chance) && length < 7.0)) return keep(room);
    for (int attempt = 0; attempt < 12; ++attempt) {
      const double offset = options_.min_side_m + 0.5 * options_.wall_m + slack * level_.random.uniform();
      const double at = room.edge(side) + offset, half = 0.5 * options_.wall_m;
      const Rect wall = room.between(side, at - half, at + half);
      const bool is_free =
          std::none_of(keep_free_.begin(), keep_free_.end(), [&](const Rect& other) { return other.grown(0.1).overlaps(wall); });
      if (!is_free) continue;
      addWall(wall, side);
      part(room.between(side, room.edge(side), wall.edge(side)));
      return part(room.between(side, wall.edge(opposite(side)), room.edge(opposite(side))));
    }
    keep(room);
  }

  std::vector<Room> take() { return std::move(rooms_); }

 private:
  void addWall(const Rect& wall, Side side) {
    const double length = wall.length(side), start = wall.start(side);
    const double door_width = length > 5.0 && level_.random.chance(0.25) ? level_.pick(1.4, 2.2) : level_.pick(0.8, 1.0);
    const double door = 0.3 + (length - door_width - 0.6) * level_.random.uniform();
    const double head = floor_m_ + std::min(2.05, clear_m_ - 0.2);
    const auto stretch = [&](double from, double to) {
      return Rect::across(side, from, to, wall.edge(side), wall.edge(opposite(side)));
    };
    const Rect opening = stretch(start + door, start + door + door_width);
    BrushGrid grid;
    grid.fill({wall.x0, floor_m_, wall.z0}, {wall.x1, floor_m_ + clear_m_, wall.z1}, level_.palette.inner_wall);
    grid.carve({opening.x0, floor_m_, opening.z0}, {opening.x1, head, opening.z1});
    // a hatch like a kitchen's: an opening above the hip
    if (length > 6.0 && level_.random.chance(0.3)) {
      const double from = start + (door > 0.5 * length ? 0.8 : length - 2.0);
      const Rect hatch = stretch(from, from + 1.2);
      grid.carve({hatch.x0, floor_m_ + 1.0, hatch.z0}, {hatch.x1, floor_m_ + 1.8, hatch.z1});
    }
    grid.emitObject(level_.mesh, "inner wall", options_.mobility);
    keep_free_.push_back(opening.grown(0.6));
  }

  void keep(const Rect& room) { rooms_.push_back({room, floor_m_, clear_m_, keep_free_}); }

  Level& level_;
  double floor_m_, clear_m_;
  const PlanOptions& options_;
  std::vector<Rect>& keep_free_;
  std::vector<Room> rooms_;
};

}  // namespace

void carveHole(Building& building, int storey, Side side, double from, double to, double low, double high, double margin_m) {
  const Rect in = building.inner();
  const double start = in.start(side);
  const Rect hole = Rect::across(side, start + from, start + to, in.edge(side), building.outer.edge(side));
  building.shell.carve({hole.x0, low, hole.z0}, {hole.x1, high, hole.z1});
  building.openings.push_back({storey, hole.grown(margin_m)});
}

double Building::floorHeight(int storey) const {
  double height = ground_m;
  for (int i = 0; i < storey; ++i) height += clear_m[i] + slab_m;
  return height;
}

std::vector<Rect> Building::openingsOf(int storey) const {
  std::vector<Rect> areas;
  for (const Opening& opening : openings) {
    if (opening.storey == storey) areas.push_back(opening.area);
  }
  return areas;
}

void addGround(Level& level, const Building& building, double margin_m) {
  const Rect area = building.outer.grown(margin_m);
  level.mesh.beginObject("ground", Mobility::structure);
  addBox(level.mesh, {}, {area.x0, -1.5, area.z0}, {area.x1, -0.02, area.z1}, level.palette.ground);
}

void fillShell(Level& level, Building& building) {
  const Rect& out = building.outer;
  const Rect in = building.inner();
  const int storey_count = building.storeyCount();
  building.shell.fill({out.x0, building.base_m, out.z0}, {out.x1, building.roofHeight(), out.z1}, level.roomFaces());
  building.shell.fill({out.x0, building.roofHeight() - building.slab_m, out.z0}, {out.x1, building.roofHeight(), out.z1},
                      level.roofFaces());
  for (int storey = 0; storey < storey_count; ++storey) {
    const double floor = building.floorHeight(storey);
    building.shell.carve({in.x0, floor, in.z0}, {in.x1, floor + building.clear_m[storey], in.z1});
    const Rect& well = building.stairwell;
    if (storey > 0 && well.width() > 0.0) {
      building.shell.carve({well.x0, floor - building.slab_m, well.z0}, {well.x1, floor, well.z1});
    }
  }
}

void carveWindows(Level& level, Building& building, int storey, double share) {
  const double floor = building.floorHeight(storey);
  const double sill = floor + level.pick(0.7, 1.0);
  const double head = floor + std::min(level.pick(1.9, 2.3), building.clear_m[storey] - 0.25);
  const double distance = level.pick(2.2, 3.4);
  const double width = level.pick(0.8, std::min(1.8, distance - 0.8));
  for (const Side side : kSides) {
    const double length = building.inner().length(side);
    const int count = static_cast<int>(length / distance);
    for (int i = 0; i < count; ++i) {
      if (!level.random.chance(share)) continue;
      const double middle = length * (i + 0.5) / count;
      carveHole(building, storey, side, middle - 0.5 * width, middle + 0.5 * width, sill, head, 0.0);
    }
  }
}

void carveDoor(Building& building, Side side, int storey, double along, double width, double height) {
  const double floor = building.floorHeight(storey);
  const double from = std::clamp(along, 0.2, building.inner().length(side) - width - 0.2);
  carveHole(building, storey, side, from, from + width, floor, floor + height, 0.6);
}

std::vector<Room> partStorey(Level& level, const Building& building, int storey, const Rect& area, const PlanOptions& options,
                             std::vector<Rect> keep_free) {
  for (const Rect& opening : building.openingsOf(storey)) keep_free.push_back(opening);
  std::vector<Rect> blocked = keep_free;
  Parter parter(level, building, storey, options, blocked);
  parter.part(area);
  std::vector<Room> rooms = parter.take();
  for (Room& room : rooms) room.keep_free = blocked;  // doors of walls that came later bound earlier rooms too
  return rooms;
}

void addFlight(Level& level, const Placement& placement, const Flight& flight, uint32_t material) {
  const int step_count = std::max(2, static_cast<int>(std::floor(flight.rise_m / 0.18 + 0.5)));
  const double rise = flight.rise_m / step_count;
  const double run = flight.run_m / step_count;
  BrushGrid grid;
  for (int step = 0; step < step_count; ++step) {
    const double low = flight.is_open ? std::max(0.0, rise * (step - 1)) : 0.0;
    grid.fill({run * step, low, -0.5 * flight.width_m}, {run * (step + 1), rise * (step + 1), 0.5 * flight.width_m}, material);
  }
  grid.emit(level.mesh, placement);
}

void addRailing(Level& level, const Placement& placement, double length) {
  if (length < 0.3) return;
  BrushGrid grid;
  const int post_count = std::max(1, static_cast<int>(length / 0.9));
  for (int post = 0; post <= post_count; ++post) {
    const double x = (length - 0.06) * post / post_count;
    grid.fill({x, 0, -0.03}, {x + 0.06, 0.95, 0.03}, level.palette.metal);
  }
  grid.fill({0, 0.95, -0.04}, {length, 1.02, 0.04}, level.palette.dark_wood);
  grid.fill({0, 0.45, -0.03}, {length, 0.5, 0.03}, level.palette.metal);
  grid.emitObject(level.mesh, "railing", Mobility::movable, placement);
}

void addBalcony(Level& level, BrushGrid& shell, const glm::dvec3& corner, double width, double reach, double low_m) {
  const double x = corner.x, y = corner.y, edge = corner.z + reach;
  shell.fill({x, low_m, corner.z}, {x + width, y, edge}, level.palette.stone);
  addRailing(level, {{x, y, edge - 0.05}, {}}, width);
  addRailing(level, {{x + 0.05, y, edge - 0.05}, turnByDegrees(90.0)}, reach - 0.1);
  addRailing(level, {{x + width - 0.05, y, edge - 0.05}, turnByDegrees(90.0)}, reach - 0.1);
}

void addGable(Level& level, const Rect& area, double eaves_m, double height_m) {
  const bool along_x = area.width() > area.depth();
  const double half = 0.5 * (along_x ? area.depth() : area.width()) + 0.4;
  const double reach = 0.5 * (along_x ? area.width() : area.depth()) + 0.3;
  const glm::dvec2 middle = area.middle();
  const Placement placement{{middle.x, eaves_m, middle.y}, turnByDegrees(along_x ? 90.0 : 0.0)};
  level.mesh.beginObject("roof", Mobility::structure);
  const std::vector<ProfilePoint> profile = {{-half, 0.0, 0.12}, {0.0, 0.0, height_m}, {half, 0.0, 0.12}};
  addProfile(level.mesh, placement, profile, -reach, reach, level.palette.roof);
}

void addColumn(Level& level, const Columns& columns, double x, double z, double height) {
  level.mesh.beginObject("column", Mobility::movable);
  const double r = columns.radius;
  const std::vector<Ring> rings = {
      {0, 1.5 * r}, {0.2, 1.5 * r}, {0.3, r}, {height - 0.35, 0.85 * r}, {height - 0.15, 1.35 * r}, {height, 1.35 * r}};
  addLathe(level.mesh, {{x, 0, z}, turnByDegrees(columns.side_count == 4 ? 45.0 : 0.0)}, rings, columns.side_count,
           level.palette.stone);
}

void addArcade(Level& level, const Columns& columns, const Placement& start, int bay_count, double top_m) {
  level.mesh.beginObject("arcade", Mobility::structure);
  const double half = 0.75 * columns.radius;
  std::vector<ProfilePoint> profile;
  if (!columns.has_arches)
    profile = {{-half, columns.column_m, top_m}, {bay_count * columns.bay + half, columns.column_m, top_m}};
  constexpr int kSegments = 10;
  const double span = 0.5 * columns.bay - half;
  if (columns.has_arches) profile.push_back({-half, columns.column_m, top_m});
  for (int bay = 0; bay < bay_count && columns.has_arches; ++bay) {
    for (int i = 0; i <= kSegments; ++i) {
      const Turn angle = turnByDegrees(180.0 * i / kSegments);
      profile.push_back({(bay + 0.5) * columns.bay - span * angle.cosine, columns.column_m + span * angle.sine, top_m});
    }
  }
  if (columns.has_arches) profile.push_back({bay_count * columns.bay + half, columns.column_m, top_m});
  addProfile(level.mesh, start, profile, -half, half, level.palette.wall);
}

void addColumnRow(Level& level, const Columns& columns, const Placement& start, int bay_count, double top_m, bool has_ends) {
  for (int i = has_ends ? 0 : 1; i <= bay_count - (has_ends ? 0 : 1); ++i) {
    const glm::dvec3 foot = start.apply({i * columns.bay, 0, 0});
    addColumn(level, columns, foot.x, foot.z, columns.column_m);
  }
  addArcade(level, columns, start, bay_count, top_m);
}

}  // namespace nlg
