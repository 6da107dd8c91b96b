// The family "cave": chambers joined by tunnels in noisy rock, with boulders, dripstone and a few things left behind.
#include <algorithm>
#include <cmath>

#include "scene/procedural/furniture.h"
#include "scene/procedural/isosurface.h"
#include "scene/procedural/level.h"
#include "scene/procedural/value_noise.h"

namespace nlg {
namespace {

// A chamber: an ellipsoid of air with a flattened floor.
struct Chamber {
  glm::dvec3 centre, radii;
};

struct Cave {
  glm::dvec3 half{10.0, 3.5, 9.0};
  std::vector<Chamber> chambers;
  double tunnel_m = 1.3;
  double rough = 0.35;
  uint64_t noise_seed = 0;
};

Cave drawCave(Level& level) {
  Cave cave;
  cave.half = {level.pick(8.0, 12.0), level.pick(3.0, 4.0), level.pick(7.0, 11.0)};
  cave.tunnel_m = level.pick(1.1, 1.7);
  cave.rough = level.random.uniform(0.25, 0.5);
  cave.noise_seed = level.random.next();
  const int count = level.pickCount(4, 7);
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 radii{level.pick(1.8, 3.8), level.pick(1.6, 2.8), level.pick(1.8, 3.8)};
    const glm::dvec3 room = glm::max(cave.half - radii - 0.8, glm::dvec3(0.2));
    cave.chambers.push_back(
        {room * glm::dvec3{level.random.uniform(-1, 1), level.random.uniform(-0.5, 0.5), level.random.uniform(-1, 1)}, radii});
  }
  return cave;
}

double segmentDistance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ap = p - a;
  const double length2 = ab.x * ab.x + ab.y * ab.y + ab.z * ab.z;
  const double t = std::clamp((ap.x * ab.x + ap.y * ab.y + ap.z * ab.z) / std::max(length2, 1e-9), 0.0, 1.0);
  const glm::dvec3 d = ap - ab * t;
  return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

// Positive in air, roughly in metres from the rock.
double airField(const Cave& cave, const glm::dvec3& p) {
  double air = -10.0;
  for (size_t i = 0; i < cave.chambers.size(); ++i) {
    const Chamber& chamber = cave.chambers[i];
    const glm::dvec3 d = (p - chamber.centre) / chamber.radii;
    const double distance = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    const double least = std::min({chamber.radii.x, chamber.radii.y, chamber.radii.z});
    // chambers have a floor: what lies below two thirds of their height is filled
    const double above_floor = p.y - (chamber.centre.y - 0.55 * chamber.radii.y);
    air = std::max(air, std::min((1.0 - distance) * least, 1.2 * above_floor));
    if (i > 0) air = std::max(air, cave.tunnel_m - segmentDistance(p, chamber.centre, cave.chambers[i - 1].centre));
  }
  air += cave.rough * fractalNoise(cave.noise_seed, p * 0.55, 3);
  // rock all around
  const glm::dvec3 wall = cave.half - glm::abs(p) - 0.4;
  return std::min({air, wall.x, wall.y, wall.z});
}

ScalarGrid sampleCave(const Cave& cave) {
  ScalarGrid grid;
  grid.spacing_m = 0.5;
  for (int axis = 0; axis < 3; ++axis) grid.count[axis] = static_cast<int>(2.0 * cave.half[axis] / grid.spacing_m) + 3;
  for (int z = 0; z < grid.count.z; ++z) {
    for (int y = 0; y < grid.count.y; ++y) {
      for (int x = 0; x < grid.count.x; ++x) {
        const bool is_border =
            x == 0 || y == 0 || z == 0 || x + 1 == grid.count.x || y + 1 == grid.count.y || z + 1 == grid.count.z;
        const glm::dvec3 p = glm::dvec3(x, y, z) * grid.spacing_m - cave.half - grid.spacing_m;
        grid.values.push_back(is_border ? -1.0 : airField(cave, p));
      }
    }
  }
  return grid;
}

// The height at which a vertical line from p downwards (step < 0) or upwards leaves the air.
double endOfAir(const Cave& cave, glm::dvec3 p, double step) {
  while (std::abs(p.y) < cave.half.y && airField(cave, p) > 0.0) p.y += step;
  return p.y;
}

void addDripstone(Level& level, const glm::dvec3& foot, double height, bool hangs) {
  level.mesh.beginObject(hangs ? "stalactite" : "stalagmite", Mobility::movable);
  const double radius = 0.12 + 0.12 * height;
  if (hangs) {
    addLathe(level.mesh, {{foot.x, foot.y - height, foot.z}, {}},
             {{0, 0.06}, {0.5 * height, 0.4 * radius}, {height + 0.3, radius}}, 7, level.palette.rock);
  } else {
    addLathe(level.mesh, {foot, {}}, {{-0.3, radius}, {0.5 * height, 0.5 * radius}, {height, 0.0}}, 7, level.palette.rock);
  }
}

void addThing(Level& level, const Cave& cave, const Chamber& chamber) {
  const glm::dvec3 inside =
      chamber.centre + chamber.radii * glm::dvec3{level.random.uniform(-0.65, 0.65), 0.0, level.random.uniform(-0.65, 0.65)};
  if (airField(cave, inside) <= 0.3) return;
  const glm::dvec3 floor(inside.x, endOfAir(cave, inside, -0.05), inside.z);
  const glm::dvec3 roof(inside.x, endOfAir(cave, inside, 0.05), inside.z);
  const double draw = level.random.uniform();
  const Placement placement{floor, turnByDegrees(level.random.uniform(0.0, 360.0))};
  if (draw < 0.4) {
    const double size = level.random.uniform(0.25, 0.9);
    level.mesh.beginObject("rock", Mobility::movable);
    addRock(level.mesh, placement, {size, 0.8 * size, 0.9 * size}, level.random.next(), level.palette.rock);
  } else if (draw < 0.6) {
    addDripstone(level, floor, level.random.uniform(0.5, 1.6), false);
  } else if (draw < 0.75) {
    addDripstone(level, roof, level.random.uniform(0.4, 1.2), true);
  } else if (draw < 0.85) {
    level.mesh.beginObject("pillar", Mobility::movable);
    const double height = roof.y - floor.y;
    addLathe(level.mesh, {floor, {}}, {{-0.4, 0.6}, {0.3 * height, 0.3}, {0.7 * height, 0.28}, {height + 0.4, 0.6}}, 8,
             level.palette.rock);
  } else if (draw < 0.95) {
    addCrate(level, placement, level.pick(0.5, 0.8));
  } else {
    level.mesh.beginObject("crystal", Mobility::movable);
    addLathe(level.mesh, placement, {{-0.2, 0.15}, {0.5, 0.2}, {0.8, 0.0}}, 6, level.palette.lamp);
  }
}

}  // namespace

void buildCave(Level& level) {
  const Cave cave = drawCave(level);
  ScalarGrid grid = sampleCave(cave);
  keepLargestAir(grid);
  level.mesh.beginObject("cave", Mobility::structure);
  addIsosurface(level.mesh, {-cave.half - grid.spacing_m, {}}, grid, level.palette.rock);
  for (const Chamber& chamber : cave.chambers) {
    for (int i = level.pickCount(3, 7); i > 0; --i) addThing(level, cave, chamber);
  }
}

}  // namespace nlg
