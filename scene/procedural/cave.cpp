// The family "cave": chambers joined by tunnels in noisy rock, with boulders, dripstone and a few things left behind.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"
#include "scene/procedural/mesh_builder.h"
#include "scene/procedural/value_noise.h"

namespace nlg {
namespace {

// The surface on which a field on a grid changes sign, by marching tetrahedra: closed, without cracks or slivers.

struct ScalarGrid {
  glm::ivec3 count{0};         // points along x, y, z, two or more each
  double spacing_m = 1.0;      // the placement's position is the first point's
  std::vector<double> values;  // count.x * count.y * count.z, x fastest; > 0 in air

  size_t index(int x, int y, int z) const { return (static_cast<size_t>(z) * count.y + y) * count.x + x; }
};

constexpr uint32_t kNoCaveVertex = ~0u;

// Paths along the cube's edges from corner 0 to corner 7 (bit 0 is x, 1 is y, 2 is z): six tetrahedra that share the diagonal
// and match across the faces of neighbouring cubes.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};

glm::ivec3 cornerOffset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

class Marcher {
 public:
  Marcher(MeshBuilder& mesh, const Placement& placement, const ScalarGrid& grid, uint32_t material)
      : mesh_(mesh), placement_(placement), grid_(grid), material_(material), vertices_(grid.values.size() * 8, kNoCaveVertex) {}

  void marchCube(const glm::ivec3& cube) {
    for (const auto& tetrahedron : kTetrahedra) {
      std::array<int, 4> air{};
      std::array<int, 4> solid{};
      int air_count = 0;
      int solid_count = 0;
      for (int i = 0; i < 4; ++i) (value(cube, tetrahedron[i]) > 0.0 ? air[air_count++] : solid[solid_count++]) = i;
      const auto cut = [&](int a, int b) { return vertex(cube, tetrahedron[a], tetrahedron[b]); };
      if (air_count == 1) emit(cut(air[0], solid[0]), cut(air[0], solid[1]), cut(air[0], solid[2]), isEven(air[0], solid));
      if (air_count == 3) emit(cut(solid[0], air[0]), cut(solid[0], air[1]), cut(solid[0], air[2]), !isEven(solid[0], air));
      if (air_count == 2) {
        const bool even = isEven(air[0], {air[1], solid[0], solid[1], 0});
        const uint32_t a = cut(air[0], solid[0]);
        const uint32_t c = cut(air[1], solid[1]);
        emit(a, cut(air[0], solid[1]), c, even);
        emit(a, c, cut(air[1], solid[0]), even);
      }
    }
  }

 private:
  double value(const glm::ivec3& cube, int corner) const {
    const glm::ivec3 p = cube + cornerOffset(corner);
    return grid_.values[grid_.index(p.x, p.y, p.z)];
  }

  // Whether (first, rest[0], rest[1], rest[2]) is an even permutation of (0, 1, 2, 3).
  static bool isEven(int first, const std::array<int, 4>& rest) {
    const std::array<int, 4> order = {first, rest[0], rest[1], rest[2]};
    int inversions = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
    }
    return inversions % 2 == 0;
  }

  // A triangle that looks away from the air when its corners stand in the even order: turned so that it looks into it.
  void emit(uint32_t a, uint32_t b, uint32_t c, bool is_even) {
    mesh_.addTriangle(a, is_even ? c : b, is_even ? b : c, material_);
  }

  // The vertex on the edge between two corners; its lower corner and its direction name it.
  uint32_t vertex(const glm::ivec3& cube, int from, int to) {
    if (from > to) std::swap(from, to);
    const glm::ivec3 low = cube + cornerOffset(from);
    uint32_t& entry = vertices_[grid_.index(low.x, low.y, low.z) * 8 + static_cast<size_t>(from ^ to)];
    if (entry == kNoCaveVertex) {
      const double a = value(cube, from);
      const double b = value(cube, to);
      const double t = std::clamp(a / (a - b), 0.1, 0.9);
      const glm::dvec3 start(low);
      const glm::dvec3 end(cube + cornerOffset(to));
      entry = mesh_.addVertex(placement_, (start + (end - start) * t) * grid_.spacing_m);
    }
    return entry;
  }

  MeshBuilder& mesh_;
  const Placement& placement_;
  const ScalarGrid& grid_;
  uint32_t material_;
  std::vector<uint32_t> vertices_;
};

// Labels the air that hangs together with a point; edges of the tetrahedra are what connects.
size_t floodAir(const ScalarGrid& grid, const glm::ivec3& start, int label, std::vector<int>& labels) {
  std::vector<glm::ivec3> open = {start};
  labels[grid.index(start.x, start.y, start.z)] = label;
  size_t count = 0;
  while (!open.empty()) {
    const glm::ivec3 p = open.back();
    open.pop_back();
    ++count;
    for (int step = 1; step < 15; ++step) {
      const glm::ivec3 q = step < 8 ? p + cornerOffset(step) : p - cornerOffset(step - 7);
      if (q.x < 0 || q.y < 0 || q.z < 0 || q.x >= grid.count.x || q.y >= grid.count.y || q.z >= grid.count.z) continue;
      const size_t idx = grid.index(q.x, q.y, q.z);
      if (grid.values[idx] <= 0.0 || labels[idx] != 0) continue;
      labels[idx] = label;
      open.push_back(q);
    }
  }
  return count;
}

// Turns every air point that is not connected with the largest body of air into solid.
void keepLargestAir(ScalarGrid& grid) {
  // labels of the bodies of air, by flood fill
  std::vector<int> labels(grid.values.size(), 0);
  int last_label = 0;
  int largest_label = 0;
  size_t largest_count = 0;
  for (int z = 0; z < grid.count.z; ++z) {
    for (int y = 0; y < grid.count.y; ++y) {
      for (int x = 0; x < grid.count.x; ++x) {
        const size_t idx = grid.index(x, y, z);
        if (grid.values[idx] <= 0.0 || labels[idx] != 0) continue;
        const size_t count = floodAir(grid, {x, y, z}, ++last_label, labels);
        if (count > largest_count) {
          largest_count = count;
          largest_label = last_label;
        }
      }
    }
  }
  // the sign turns, the magnitude stays: a pocket becomes rock
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != largest_label && grid.values[i] > 0.0) grid.values[i] = -grid.values[i];
  }
}

// Front faces look into the air. Closed when all points of the grid's border are solid: the surface then is a shell around
// the air whose signed volume is negative. Vertices keep a tenth of an edge's length away from grid points.
void addIsosurface(MeshBuilder& mesh, const Placement& placement, const ScalarGrid& grid, uint32_t material) {
  Marcher marcher(mesh, placement, grid, material);
  for (int z = 0; z + 1 < grid.count.z; ++z) {
    for (int y = 0; y + 1 < grid.count.y; ++y) {
      for (int x = 0; x + 1 < grid.count.x; ++x) marcher.marchCube({x, y, z});
    }
  }
}

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
  // not at the rim of the chamber, and well off the rock
  const glm::dvec3 inside =
      chamber.centre + chamber.radii * glm::dvec3{level.random.uniform(-0.65, 0.65), 0.0, level.random.uniform(-0.65, 0.65)};
  if (airField(cave, inside) <= 0.3) return;
  // floor and roof in steps of 5 cm
  const glm::dvec3 floor(inside.x, endOfAir(cave, inside, -0.05), inside.z);
  const glm::dvec3 roof(inside.x, endOfAir(cave, inside, 0.05), inside.z);
  const double draw = level.random.uniform();
  const Placement placement{floor, turnByDegrees(level.random.uniform(0.0, 360.0))};
  // feet reach into the rock, which is uneven: nothing floats
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
