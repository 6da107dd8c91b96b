// The family "outdoor": uneven ground with small buildings that have interiors, walls, rocks, trees and ruins.
#include <algorithm>

#include "scene/procedural/building.h"
#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"
#include "scene/procedural/value_noise.h"

namespace nlg {
namespace {

// A place on which the ground is level.
struct Pad {
  Rect area;
  double height_m;
};

class Terrain {
 public:
  Terrain(Level& level, double half_m) : seed_(level.random.next()), relief_m_(level.pick(0.5, 1.6)), half_m_(half_m) {}

  double half() const { return half_m_; }

  double wild(double x, double z) const {
    const double hills = fractalNoise(seed_, {x * 0.09, 0.0, z * 0.09}, 3);
    return relief_m_ * hills;
  }

  // Pads first, blended into the hills over two metres.
  double height(double x, double z) const {
    double height = wild(x, z);
    for (const Pad& pad : pads_) {
      const double dx = std::max({pad.area.x0 - x, x - pad.area.x1, 0.0});
      const double dz = std::max({pad.area.z0 - z, z - pad.area.z1, 0.0});
      const double t = std::clamp(1.0 - std::sqrt(dx * dx + dz * dz) / 2.0, 0.0, 1.0);
      const double blend = t * t * (3.0 - 2.0 * t);
      height += (pad.height_m - height) * blend;
    }
    return height;
  }

  // Null where another pad is too near.
  const Pad* reserve(const Rect& area) {
    for (const Pad& pad : pads_) {
      if (pad.area.overlaps(area.grown(2.2))) return nullptr;
    }
    const glm::dvec2 middle = area.middle();
    pads_.push_back({area, wild(middle.x, middle.y)});
    return &pads_.back();
  }

  bool isBuilt(double x, double z, double margin) const {
    const Rect point{x - margin, z - margin, x + margin, z + margin};
    return std::any_of(pads_.begin(), pads_.end(), [&](const Pad& pad) { return pad.area.overlaps(point); });
  }

 private:
  uint64_t seed_;
  double relief_m_, half_m_;
  std::vector<Pad> pads_;
};

void addTerrain(Level& level, const Terrain& terrain) {
  Heightfield field;
  field.spacing_m = 0.75;
  field.x_count = field.z_count = static_cast<int>(2.0 * terrain.half() / field.spacing_m) + 1;
  field.base_m = -5.0;
  for (int z = 0; z < field.z_count; ++z) {
    for (int x = 0; x < field.x_count; ++x) {
      const double height = terrain.height(x * field.spacing_m - terrain.half(), z * field.spacing_m - terrain.half());
      field.height_m.push_back(std::max(height, -4.5));
    }
  }
  level.mesh.beginObject("ground", Mobility::structure);
  addHeightfield(level.mesh, {{-terrain.half(), 0, -terrain.half()}, {}}, field, level.palette.ground);
}

Building drawHut(Level& level, double half) {
  Building building;
  const double width = level.pick(5.0, 8.0);
  const double depth = level.pick(4.5, 7.0);
  const double x = level.random.uniform(-half + 1.5, half - width - 1.5);
  const double z = level.random.uniform(-half + 1.5, half - depth - 1.5);
  building.outer = {x, z, x + width, z + depth};
  building.wall_m = level.pick(0.2, 0.4);
  building.clear_m = {level.pick(2.4, 3.0)};
  return building;
}

void addHut(Level& level, Building& building, double ground_m) {
  building.ground_m = ground_m + 0.15;
  building.base_m = ground_m - 0.8;
  fillShell(level, building);
  carveWindows(level, building, 0, 0.6);
  const Side front = kSides[level.random.below(4)];
  const double along = level.random.uniform(0.3, 4.0);
  carveDoor(building, front, 0, along, level.pick(0.9, 1.2));
  building.shell.emitObject(level.mesh, "hut", Mobility::structure);
  if (level.random.chance(0.7)) addGable(level, building.outer, building.roofHeight(), level.pick(0.8, 1.8));
  PlanOptions options;
  options.min_side_m = 2.2;
  options.stop_chance = 0.4;
  for (const Room& room : partStorey(level, building, 0, building.inner(), options, {})) {
    const RoomUse use = level.random.chance(0.5) ? RoomUse::living : RoomUse::store;
    furnishRoom(level, room, use, level.random.uniform(0.3, 0.8));
  }
}

// A garden wall that follows the ground in pieces of two metres; some are broken down.
void addGardenWall(Level& level, const Terrain& terrain) {
  const double height = level.pick(1.2, 2.4);
  const int quarters = level.pickCount(0, 3);
  const double degrees = 90.0 * quarters + level.random.uniform(-15.0, 15.0);
  const Turn turn = turnByDegrees(degrees);
  glm::dvec3 p{level.random.uniform(-0.7, 0.7) * terrain.half(), 0, level.random.uniform(-0.7, 0.7) * terrain.half()};
  for (int piece = level.pickCount(4, 9); piece > 0; --piece, p += turned(turn, {2.0, 0, 0})) {
    const glm::dvec3 end = p + turned(turn, {2.0, 0, 0});
    const double limit = terrain.half() - 0.5;
    if (std::max({std::abs(p.x), std::abs(p.z), std::abs(end.x), std::abs(end.z)}) > limit) return;
    if (terrain.isBuilt(p.x, p.z, 1.0) || terrain.isBuilt(end.x, end.z, 1.0) || level.random.chance(0.1)) continue;
    const double foot = std::min(terrain.height(p.x, p.z), terrain.height(end.x, end.z));
    const double left = level.random.chance(0.2) ? 0.4 * height : height;
    const double right = level.random.chance(0.2) ? 0.5 * height : height;
    level.mesh.beginObject("garden wall", Mobility::movable);
    const std::vector<ProfilePoint> profile = {{0.0, -0.4, left}, {1.0, -0.4, 0.5 * (left + right) + 0.1}, {2.0, -0.4, right}};
    addProfile(level.mesh, {{p.x, foot, p.z}, turn}, profile, -0.15, 0.15, level.palette.stone);
  }
}

void addBoulder(Level& level, const glm::dvec3& foot) {
  const double size = level.random.uniform(0.3, 1.4);
  level.mesh.beginObject("rock", Mobility::movable);
  const glm::dvec3 radii{size, size * level.random.uniform(0.5, 0.9), size * level.random.uniform(0.6, 1.0)};
  const Placement placement{{foot.x, foot.y + 0.2 * size, foot.z}, turnByDegrees(level.random.uniform(0.0, 360.0))};
  addRock(level.mesh, placement, radii, level.random.next(), level.palette.rock);
}

// A ring of columns on a round base, some broken, as a pavilion or a ruin.
void addPavilion(Level& level, Terrain& terrain) {
  const double radius = level.pick(2.0, 3.2);
  // the terrain is levelled below it; without a free place there is no pavilion
  const double limit = terrain.half() - radius - 1.5;
  const glm::dvec2 at{level.random.uniform(-limit, limit), level.random.uniform(-limit, limit)};
  const Pad* pad = terrain.reserve(Rect{at.x, at.y, at.x, at.y}.grown(radius + 0.3));
  if (pad == nullptr) return;
  const glm::dvec3 foot(at.x, pad->height_m, at.y);
  level.mesh.beginObject("base", Mobility::structure);
  addLathe(level.mesh, {foot, {}}, {{-0.6, radius + 0.3}, {0.17, radius + 0.3}, {0.17, radius}, {0.34, radius}}, 16,
           level.palette.stone);
  const bool is_roofed = level.random.chance(0.6);
  const int column_count = level.pickCount(6, 9);
  const double height = level.pick(2.4, 3.2);
  // a ruin: half of the columns broken, .3 to .8 of their height left
  for (int i = 0; i < column_count; ++i) {
    const glm::dvec3 arm = turned(turnByDegrees(360.0 * i / column_count), {radius - 0.3, 0, 0});
    const double top = is_roofed || level.random.chance(0.5) ? height : height * level.random.uniform(0.3, 0.8);
    level.mesh.beginObject("column", Mobility::movable);
    addLathe(level.mesh, {foot + arm, {}}, {{0.3, 0.2}, {0.45, 0.16}, {top, 0.14}}, 8, level.palette.stone);
  }
  if (!is_roofed) return;
  level.mesh.beginObject("dome", Mobility::structure);
  addLathe(level.mesh, {foot, {}}, {{height, radius}, {height + 0.25, radius}, {height + 0.9, 0.7 * radius}, {height + 1.3, 0.0}},
           16, level.palette.roof);
}

void scatter(Level& level, const Terrain& terrain, int count, void (*add)(Level&, const glm::dvec3&), double margin) {
  for (int i = 0; i < count; ++i) {
    const double limit = terrain.half() - 1.5;
    const double x = level.random.uniform(-limit, limit);
    const double z = level.random.uniform(-limit, limit);
    if (!terrain.isBuilt(x, z, margin)) add(level, {x, terrain.height(x, z), z});
  }
}

}  // namespace

void buildOutdoor(Level& level) {
  Terrain terrain(level, level.pick(10.5, 13.5));
  std::vector<std::pair<Building, double>> huts;
  const int wanted = level.pickCount(2, 3);
  for (int attempt = 0; attempt < 30 && static_cast<int>(huts.size()) < wanted; ++attempt) {
    const Building hut = drawHut(level, terrain.half());
    const Pad* pad = terrain.reserve(hut.outer.grown(0.5));
    if (pad != nullptr) huts.emplace_back(hut, pad->height_m);
  }
  addPavilion(level, terrain);
  addTerrain(level, terrain);
  for (auto& [hut, ground_m] : huts) addHut(level, hut, ground_m);
  for (int i = level.pickCount(1, 3); i > 0; --i) addGardenWall(level, terrain);
  scatter(level, terrain, level.pickCount(6, 14), addBoulder, 1.2);
  scatter(level, terrain, level.pickCount(3, 8), addTree, 1.6);
}

}  // namespace nlg
