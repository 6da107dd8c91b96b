// The family "colonnade": a hall of columns with arcades, aisles and galleries, as basilica, cloister or market hall.
#include <algorithm>

#include "scene/procedural/building.h"
#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"

namespace nlg {
namespace {

enum class Plan { basilica, cloister, hypostyle };

struct Hall : Columns {
  Plan plan = Plan::basilica;
  double length = 18.0, nave = 7.0, aisle = 3.0;  // along x; across z
  double wall_m = 0.4;

  double depth() const { return nave + 2.0 * aisle; }
  double aisleHeight() const { return column_m + archRise() + 0.3; }
};

Hall drawHall(Level& level) {
  Hall hall;
  hall.plan = static_cast<Plan>(level.pickCount(0, 2));
  hall.bay = level.pick(2.4, 3.6);
  hall.length = hall.bay * level.pickCount(5, 8);
  hall.nave = level.pick(5.0, 8.0);
  hall.aisle = level.pick(2.2, 3.6);
  hall.column_m = level.pick(2.4, 3.6);
  hall.radius = level.pick(0.2, 0.4);
  hall.side_count = level.random.chance(0.3) ? 4 : level.pickCount(8, 14);
  hall.has_arches = level.random.chance(0.65);
  hall.wall_m = level.pick(0.3, 0.4);
  return hall;
}

// Outer walls, floor and the roofs over nave and aisles; upper windows where the nave rises above them.
void addBasilicaShell(Level& level, const Hall& hall, double nave_m) {
  const double x = 0.5 * hall.length;
  const double z = 0.5 * hall.depth();
  const double nave_z = 0.5 * hall.nave;
  const double w = hall.wall_m;
  // solid blocks first, then air: what is left between them are walls and roofs
  BrushGrid grid;
  grid.fill({-x - w, -0.5, -z - w}, {x + w, hall.aisleHeight() + 0.3, z + w}, level.roomFaces());
  grid.fill({-x - w, -0.5, -nave_z - 0.2}, {x + w, nave_m + 0.3, nave_z + 0.2}, level.roomFaces());
  // roofs have a material of their own
  const BrushMaterials roof = level.roofFaces();
  grid.fill({-x - w, hall.aisleHeight(), -z - w}, {x + w, hall.aisleHeight() + 0.3, -nave_z - 0.2}, roof);
  grid.fill({-x - w, hall.aisleHeight(), nave_z + 0.2}, {x + w, hall.aisleHeight() + 0.3, z + w}, roof);
  grid.fill({-x - w, nave_m, -nave_z - 0.2}, {x + w, nave_m + 0.3, nave_z + 0.2}, roof);
  grid.carve({-x, 0, -z}, {x, hall.aisleHeight(), z});
  grid.carve({-x, 0, -nave_z + 0.2}, {x, nave_m, nave_z - 0.2});
  // a window in most bays of the aisles, and one in every bay of the upper wall on both sides
  const int bay_count = static_cast<int>(hall.length / hall.bay + 0.5);
  const double sill = level.pick(0.9, 1.6);
  for (int bay = 0; bay < bay_count; ++bay) {
    const double at = -x + (bay + 0.5) * hall.bay;
    if (level.random.chance(0.7)) grid.carve({at - 0.5, sill, -z - w}, {at + 0.5, hall.column_m, -z});
    if (level.random.chance(0.7)) grid.carve({at - 0.5, sill, z}, {at + 0.5, hall.column_m, z + w});
    grid.carve({at - 0.4, hall.aisleHeight() + 0.6, -nave_z - 0.2}, {at + 0.4, nave_m - 0.4, nave_z + 0.2});
  }
  // the portal in the west, an east window by chance
  grid.carve({-x - w, 0, -1.1}, {-x, 3.0, 1.1});
  if (level.random.chance(0.6)) grid.carve({x, sill + 1.0, -0.8}, {x + w, nave_m - 0.8, 0.8});
  grid.emitObject(level.mesh, "shell", Mobility::structure);
}

void addBenches(Level& level, const Hall& hall) {
  for (double x = -0.25 * hall.length; x < 0.3 * hall.length; x += level.pick(1.0, 1.6)) {
    for (const double side : {-1.0, 1.0}) {
      if (level.random.chance(0.2)) continue;
      const double half = 0.25 * hall.nave - 0.6;
      BrushGrid grid;
      grid.fill({-0.2, 0, -half}, {0.2, 0.45, -half + 0.08}, level.palette.dark_wood);
      grid.fill({-0.2, 0, half - 0.08}, {0.2, 0.45, half}, level.palette.dark_wood);
      grid.fill({-0.2, 0.4, -half}, {0.2, 0.46, half}, level.palette.dark_wood);
      grid.fill({-0.2, 0.4, -half}, {-0.14, 0.95, half}, level.palette.dark_wood);
      grid.emitObject(level.mesh, "bench", Mobility::movable, {{x, 0, side * (0.25 * hall.nave)}, {}});
    }
  }
}

void buildBasilica(Level& level, const Hall& hall) {
  const double nave_m = hall.aisleHeight() + level.pick(1.8, 3.0);
  addBasilicaShell(level, hall, nave_m);
  const int bay_count = static_cast<int>(hall.length / hall.bay + 0.5);
  for (const double side : {-1.0, 1.0}) {
    const Placement start{{-0.5 * hall.length, 0, side * 0.5 * hall.nave}, {}};
    addColumnRow(level, hall, start, bay_count, hall.aisleHeight(), false);
  }
  if (level.random.chance(0.7)) addBenches(level, hall);
  // a stepped platform at the far end with an altar
  BrushGrid grid;
  const double x = 0.5 * hall.length;
  const double z = 0.5 * hall.nave - 0.6;
  for (int step = 0; step < 3; ++step) grid.fill({x - 3.0 + 0.4 * step, 0, -z}, {x, 0.17 * (step + 1), z}, level.palette.stone);
  grid.fill({x - 1.6, 0, -0.9}, {x - 0.9, 1.45, 0.9}, level.palette.stone);
  grid.emitObject(level.mesh, "platform", Mobility::structure);
}

// A court with a walk around it: columns carry a lean-to roof between court and outer wall.
void buildCloister(Level& level, const Hall& hall) {
  const int x_bays = std::max(3, static_cast<int>(0.75 * hall.length / hall.bay));
  const int z_bays = level.pickCount(3, 4);
  const double x = 0.5 * x_bays * hall.bay;
  const double z = 0.5 * z_bays * hall.bay;
  const double top = hall.aisleHeight();
  const double w = hall.wall_m;
  const Rect in{-x - hall.aisle, -z - hall.aisle, x + hall.aisle, z + hall.aisle};
  // a block with roof, the walk carved into it, then the court, open to the sky and 15 cm deeper
  BrushGrid grid;
  grid.fill({in.x0 - w, -0.5, in.z0 - w}, {in.x1 + w, top + 0.3, in.z1 + w}, level.roomFaces());
  const BrushMaterials roof = level.roofFaces();
  grid.fill({in.x0 - w, top, in.z0 - w}, {in.x1 + w, top + 0.3, in.z1 + w}, roof);
  grid.carve({in.x0, 0, in.z0}, {in.x1, top, in.z1});
  grid.carve({-x, top, -z}, {x, top + 0.3, z});
  grid.carve({-x + 0.4, -0.15, -z + 0.4}, {x - 0.4, 0, z - 0.4});
  // the entrance, windows to the south, by chance a door in the east
  grid.carve({in.x0 - w, 0, -0.6}, {in.x0, 2.1, 0.6});
  for (int i = 0; i < 3; ++i) {
    const double at = level.random.uniform(in.x0 + 0.5, in.x1 - 1.5);
    grid.carve({at, 0.9, in.z1}, {at + 1.0, 2.2, in.z1 + w});
  }
  if (level.random.chance(0.5)) grid.carve({in.x1, 0, -0.7}, {in.x1 + w, 2.3, 0.7});
  grid.emitObject(level.mesh, "shell", Mobility::structure);
  // four rows of columns between walk and court
  addColumnRow(level, hall, {{-x, 0, -z}, {}}, x_bays, top, true);
  addColumnRow(level, hall, {{-x, 0, z}, {}}, x_bays, top, true);
  addColumnRow(level, hall, {{-x, 0, z}, turnByDegrees(90.0)}, z_bays, top, false);
  addColumnRow(level, hall, {{x, 0, z}, turnByDegrees(90.0)}, z_bays, top, false);
  level.mesh.beginObject("well", Mobility::movable);
  const double r = level.pick(0.7, 1.4);
  addLathe(level.mesh, {{0, -0.15, 0}, {}}, {{0, r}, {0.3, r}, {0.3, 0.8 * r}, {0.9, 0.75 * r}, {1.0, 0.9 * r}}, 12,
           level.palette.stone);
}

// A forest of columns under one flat roof; the middle rows carry a lantern.
void buildHypostyle(Level& level, const Hall& hall) {
  const int x_bays = std::min(6, static_cast<int>(hall.length / hall.bay + 0.5));
  const int z_bays = level.pickCount(3, 5);
  const double x = 0.5 * x_bays * hall.bay;
  const double z = 0.5 * z_bays * hall.bay;
  const double top = hall.aisleHeight();
  const double w = hall.wall_m;
  // a block, the hall carved into it, and a lantern above its middle rows
  BrushGrid grid;
  grid.fill({-x - w, -0.5, -z - w}, {x + w, top + 0.3, z + w}, level.roomFaces());
  const BrushMaterials roof = level.roofFaces();
  grid.fill({-x - w, top, -z - w}, {x + w, top + 0.3, z + w}, roof);
  grid.fill({-0.6 * x, top, -0.5 * z}, {0.6 * x, top + 1.5, 0.5 * z}, roof);
  grid.carve({-x, 0, -z}, {x, top, z});
  grid.carve({-0.6 * x + 0.3, top, -0.5 * z + 0.3}, {0.6 * x - 0.3, top + 1.2, 0.5 * z - 0.3});
  // doors to the south, windows to the north, and the lantern's windows on both sides
  for (int bay = 0; bay < x_bays; ++bay) {
    const double at = -x + (bay + 0.5) * hall.bay;
    if (level.random.chance(0.6)) grid.carve({at - 0.6, 0, z}, {at + 0.6, 2.4, z + w});
    if (level.random.chance(0.8)) grid.carve({at - 0.5, 1.0, -z - w}, {at + 0.5, 2.6, -z});
    if (at > -0.5 * x && at < 0.5 * x) grid.carve({at - 0.4, top + 0.5, -0.5 * z}, {at + 0.4, top + 1.1, 0.5 * z});
  }
  grid.emitObject(level.mesh, "shell", Mobility::structure);
  for (int row = 1; row < z_bays; ++row) addColumnRow(level, hall, {{-x, 0, -z + row * hall.bay}, {}}, x_bays, top, false);
  // piles of crates in the middle of bays
  for (int i = level.pickCount(4, 9); i > 0; --i) {
    const int column = level.pickCount(0, x_bays - 1);
    const int row = level.pickCount(0, z_bays - 1);
    addCratePile(level, {{-x + (column + 0.5) * hall.bay, 0, -z + (row + 0.5) * hall.bay}, turnByDegrees(level.pick(0.0, 90.0))},
                 2);
  }
}

}  // namespace

void buildColonnade(Level& level) {
  const Hall hall = drawHall(level);
  level.mesh.beginObject("ground", Mobility::structure);
  const double reach = 0.5 * hall.length + 4.0;
  addBox(level.mesh, {}, {-reach, -1.5, -reach + 2.0}, {reach, -0.05, reach - 2.0}, level.palette.ground);
  if (hall.plan == Plan::basilica) buildBasilica(level, hall);
  if (hall.plan == Plan::cloister) buildCloister(level, hall);
  if (hall.plan == Plan::hypostyle) buildHypostyle(level, hall);
}

}  // namespace nlg
