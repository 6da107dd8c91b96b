// The family "maze": corridors between thick walls, partly under a ceiling, with gates, windows, niches and a few chambers.
#include <array>

#include "scene/procedural/building.h"
#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"

namespace nlg {
namespace {

struct Maze {
  int x_count = 0, z_count = 0;
  double cell_m = 2.5, wall_m = 0.3, height_m = 3.0;
  // whether a wall stands on the cell's +x and +z side
  std::vector<char> east, south;

  size_t cell(int x, int z) const { return static_cast<size_t>(z) * x_count + x; }
  double xAt(int x) const { return (x - 0.5 * x_count) * cell_m; }
  double zAt(int z) const { return (z - 0.5 * z_count) * cell_m; }
};

void removeWall(Maze& maze, int x, int z, int direction) {
  if (direction == 0) maze.east[maze.cell(x, z)] = 0;
  if (direction == 1) maze.east[maze.cell(x - 1, z)] = 0;
  if (direction == 2) maze.south[maze.cell(x, z)] = 0;
  if (direction == 3) maze.south[maze.cell(x, z - 1)] = 0;
}

// Depth-first: every cell is reached once; loops come afterwards.
void carveCorridors(Level& level, Maze& maze) {
  constexpr std::array<std::array<int, 2>, 4> kSteps = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  std::vector<char> is_seen(maze.east.size(), 0);
  // back-tracking with a stack of its own: a corridor may be longer than recursion is deep
  std::vector<glm::ivec2> path = {{0, 0}};
  is_seen[0] = 1;
  while (!path.empty()) {
    const glm::ivec2 p = path.back();
    // the first direction is drawn, the other three follow in turn
    const int first = level.pickCount(0, 3);
    bool went = false;
    for (int turn = 0; turn < 4 && !went; ++turn) {
      const int direction = (first + turn) % 4;
      const glm::ivec2 q = p + glm::ivec2(kSteps[direction][0], kSteps[direction][1]);
      if (q.x < 0 || q.y < 0 || q.x >= maze.x_count || q.y >= maze.z_count || is_seen[maze.cell(q.x, q.y)]) continue;
      removeWall(maze, p.x, p.y, direction);
      is_seen[maze.cell(q.x, q.y)] = 1;
      path.push_back(q);
      went = true;
    }
    if (!went) path.pop_back();
  }
}

void openLoopsAndChambers(Level& level, Maze& maze) {
  for (int z = 0; z < maze.z_count; ++z) {
    for (int x = 0; x < maze.x_count; ++x) {
      if (x + 1 < maze.x_count && level.random.chance(0.07)) removeWall(maze, x, z, 0);
      if (z + 1 < maze.z_count && level.random.chance(0.07)) removeWall(maze, x, z, 2);
    }
  }
  const int chamber_count = level.pickCount(1, 3);
  for (int i = 0; i < chamber_count; ++i) {
    const int x = level.pickCount(0, maze.x_count - 2);
    const int z = level.pickCount(0, maze.z_count - 2);
    removeWall(maze, x, z, 0);
    removeWall(maze, x, z + 1, 0);
    removeWall(maze, x, z, 2);
    removeWall(maze, x + 1, z, 2);
  }
}

// One straight wall along local x, with a gate, a slit or a niche in some of its cells.
void addMazeWall(Level& level, const Maze& maze, const Placement& placement, int cell_count) {
  const double half = 0.5 * maze.wall_m;
  const double length = cell_count * maze.cell_m;
  const double height = level.random.chance(0.15) ? level.pick(1.2, 2.0) : maze.height_m;
  BrushGrid grid;
  grid.fill({-half, 0, -half}, {length + half, height, half}, level.palette.inner_wall);
  for (int cell = 0; cell < cell_count && height > 2.2; ++cell) {
    const double x = (cell + 0.5) * maze.cell_m;
    const double draw = level.random.uniform();
    if (draw < 0.12) grid.carve({x - 0.5, 0, -half}, {x + 0.5, 2.05, half});
    if (draw >= 0.12 && draw < 0.25) grid.carve({x - 0.4, 1.1, -half}, {x + 0.4, 1.8, half});
    if (draw >= 0.25 && draw < 0.35) grid.carve({x - 0.35, 0.4, 0}, {x + 0.35, 1.9, half});
  }
  grid.emitObject(level.mesh, "inner wall", Mobility::movable, placement);
}

void addInnerWalls(Level& level, const Maze& maze) {
  for (int z = 0; z + 1 < maze.z_count; ++z) {
    for (int x = 0; x < maze.x_count;) {
      int end = x;
      while (end < maze.x_count && maze.south[maze.cell(end, z)]) ++end;
      if (end > x) addMazeWall(level, maze, {{maze.xAt(x), 0, maze.zAt(z + 1)}, {}}, end - x);
      x = end + 1;
    }
  }
  for (int x = 0; x + 1 < maze.x_count; ++x) {
    for (int z = 0; z < maze.z_count;) {
      int end = z;
      while (end < maze.z_count && maze.east[maze.cell(x, end)]) ++end;
      if (end > z) addMazeWall(level, maze, {{maze.xAt(x + 1), 0, maze.zAt(z)}, turnByDegrees(270.0)}, end - z);
      z = end + 1;
    }
  }
}

void addShell(Level& level, const Maze& maze) {
  const Rect in{maze.xAt(0), maze.zAt(0), maze.xAt(maze.x_count), maze.zAt(maze.z_count)};
  const Rect out = in.grown(0.4);
  BrushGrid grid;
  grid.fill({out.x0, -0.5, out.z0}, {out.x1, maze.height_m + 0.3, out.z1}, level.roomFaces());
  grid.carve({in.x0, 0, in.z0}, {in.x1, maze.height_m, in.z1});
  // light wells over some cells, or no ceiling at all
  const bool is_roofed = level.random.chance(0.7);
  if (!is_roofed) grid.carve({in.x0, maze.height_m, in.z0}, {in.x1, maze.height_m + 0.3, in.z1});
  const int well_count = is_roofed ? maze.x_count * maze.z_count / 5 : 0;
  for (int i = 0; i < well_count; ++i) {
    const double x = maze.xAt(level.pickCount(0, maze.x_count - 1)) + 0.4;
    const double z = maze.zAt(level.pickCount(0, maze.z_count - 1)) + 0.4;
    grid.carve({x, maze.height_m, z}, {x + maze.cell_m - 0.8, maze.height_m + 0.3, z + maze.cell_m - 0.8});
  }
  // the entrance in the north, the exit in the east
  const double entry = maze.xAt(level.pickCount(0, maze.x_count - 1)) + 0.5 * maze.cell_m;
  grid.carve({entry - 0.6, 0, out.z0}, {entry + 0.6, 2.2, in.z0});
  const double exit = maze.zAt(level.pickCount(0, maze.z_count - 1)) + 0.5 * maze.cell_m;
  grid.carve({in.x1, 0, exit - 0.6}, {out.x1, 2.2, exit + 0.6});
  grid.emitObject(level.mesh, "shell", Mobility::structure);
}

void addProps(Level& level, const Maze& maze) {
  for (int z = 0; z < maze.z_count; ++z) {
    for (int x = 0; x < maze.x_count; ++x) {
      const double draw = level.random.uniform();
      const double side = 0.3 * maze.cell_m;
      const Placement placement{{maze.xAt(x) + 0.5 * maze.cell_m + level.random.uniform(-0.1, 0.1) * maze.cell_m, 0,
                                 maze.zAt(z) + 0.5 * maze.cell_m + level.random.uniform(-0.1, 0.1) * maze.cell_m},
                                turnByDegrees(level.random.uniform(0.0, 90.0))};
      if (draw < 0.08) addCrate(level, placement, level.pick(0.5, std::min(0.9, side)));
      if (draw >= 0.08 && draw < 0.14) addBarrel(level, placement, level.pick(0.8, 1.1));
      if (draw >= 0.14 && draw < 0.20) {
        level.mesh.beginObject("pillar", Mobility::movable);
        const double radius = level.pick(0.15, 0.3);
        addLathe(level.mesh, placement, {{0, radius}, {maze.height_m, radius}}, level.pickCount(4, 10), level.palette.stone);
      }
      if (draw >= 0.9) addCeilingLamp(level, {{placement.position.x, maze.height_m, placement.position.z}, {}});
    }
  }
}

}  // namespace

void buildMaze(Level& level) {
  Maze maze;
  maze.x_count = level.pickCount(6, 9);
  maze.z_count = level.pickCount(6, 9);
  maze.cell_m = level.pick(2.0, 3.2);
  maze.wall_m = level.pick(0.15, 0.4);
  maze.height_m = level.pick(2.5, 3.6);
  maze.east.assign(static_cast<size_t>(maze.x_count) * maze.z_count, 1);
  maze.south = maze.east;
  carveCorridors(level, maze);
  openLoopsAndChambers(level, maze);
  addShell(level, maze);
  addInnerWalls(level, maze);
  addProps(level, maze);
}

}  // namespace nlg
