// The family "stairs": a tall hall with mezzanines on pillars, flights between them, railings and a spiral stair.
#include <algorithm>

#include "scene/procedural/building.h"
#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"

namespace nlg {
namespace {

Placement facing(const glm::dvec3& position, double degrees) { return {position, turnByDegrees(degrees)}; }

// A mezzanine along one wall: its area and height, on pillars.
struct Deck {
  Rect area;
  double floor_m;
};

void addDeck(Level& level, const Deck& deck) {
  constexpr double kThick = 0.25;
  BrushGrid grid;
  const Rect& a = deck.area;
  grid.fill({a.x0, deck.floor_m - kThick, a.z0}, {a.x1, deck.floor_m, a.z1},
            BrushMaterials(level.palette.stone, level.palette.floor, level.palette.ceiling));
  const double distance = level.pick(2.5, 3.8);
  const double half = level.pick(0.1, 0.2);
  const int x_count = std::max(1, static_cast<int>(a.width() / distance));
  const int z_count = std::max(1, static_cast<int>(a.depth() / distance));
  for (int ix = 0; ix <= x_count; ++ix) {
    for (int iz = 0; iz <= z_count; ++iz) {
      const double x = a.x0 + 0.3 + (a.width() - 0.6) * ix / x_count;
      const double z = a.z0 + 0.3 + (a.depth() - 0.6) * iz / z_count;
      grid.fill({x - half, 0, z - half}, {x + half, deck.floor_m - kThick, z + half}, level.palette.stone);
    }
  }
  grid.emitObject(level.mesh, "deck", Mobility::structure);
}

// A railing along an edge of the deck with a gap where the flight arrives.
void addEdgeRailing(Level& level, const glm::dvec3& from, double degrees, double length, double gap_from, double gap_to) {
  const Placement start = facing(from, degrees);
  addRailing(level, start, std::clamp(gap_from, 0.0, length));
  if (gap_to < length) addRailing(level, {start.apply({gap_to, 0, 0}), start.turn}, length - std::max(0.0, gap_to));
}

void addSpiral(Level& level, const glm::dvec3& foot, double rise_m, double radius) {
  level.mesh.beginObject("spiral", Mobility::structure);
  addLathe(level.mesh, facing(foot, 0.0), {{0, 0.12}, {rise_m + 1.0, 0.12}}, 8, level.palette.metal);
  const int step_count = static_cast<int>(rise_m / 0.2);
  const double first = level.pick(0.0, 360.0);
  for (int step = 0; step < step_count; ++step) {
    const double top = rise_m * (step + 1) / step_count;
    const Placement placement = facing(foot, first + 24.0 * step);
    // a tread wider outside than inside, as a profile laid along x would be: two half boxes
    BrushGrid grid;
    grid.fill({0.05, top - 0.08, -0.12}, {0.5 * radius, top, 0.12}, level.palette.metal);
    grid.fill({0.5 * radius, top - 0.08, -0.2}, {radius, top, 0.2}, level.palette.metal);
    if (step % 3 == 0) grid.fill({radius - 0.06, top, -0.03}, {radius, top + 0.9, 0.03}, level.palette.metal);
    grid.emit(level.mesh, placement);
  }
}

struct StairPlan {
  Building building;
  std::vector<Deck> decks;
};

// Decks wind up around the walls: west, north, east; each higher than the last.
StairPlan drawPlan(Level& level) {
  StairPlan plan;
  Building& building = plan.building;
  const double width = level.pick(11.0, 16.0);
  const double depth = level.pick(10.0, 15.0);
  building.outer = {-0.5 * width, -0.5 * depth, 0.5 * width, 0.5 * depth};
  building.wall_m = level.pick(0.3, 0.4);
  building.slab_m = 0.3;
  building.base_m = -0.5;
  const double rise = level.pick(2.5, 3.2);
  const int deck_count = level.pickCount(2, 3);
  building.clear_m = {rise * deck_count + level.pick(2.4, 3.2)};
  const Rect in = building.inner();
  const double reach = level.pick(2.4, 3.4);
  plan.decks.push_back({{in.x0 + 0.02, in.z0 + 0.02, in.x0 + reach, in.z1 - level.pick(0.0, 3.0) - 0.02}, rise});
  plan.decks.push_back({{in.x0 + 0.02, in.z0 + 0.02, in.x1 - level.pick(0.0, 2.0) - 0.02, in.z0 + reach}, 2.0 * rise});
  if (deck_count > 2)
    plan.decks.push_back({{in.x1 - reach, in.z0 + 0.02, in.x1 - 0.02, in.z1 - level.pick(0.0, 4.0) - 0.02}, 3.0 * rise});
  return plan;
}

void addFlights(Level& level, const StairPlan& plan) {
  const double width = level.pick(1.0, 1.5);
  const bool is_open = level.random.chance(0.6);
  // all flights have one slope, 1.45 along for 1 up
  const auto add = [&](const glm::dvec3& foot, double degrees, double rise_m) {
    level.mesh.beginObject("flight", Mobility::structure);
    addFlight(level, facing(foot, degrees), {rise_m, 1.45 * rise_m, width, is_open}, level.palette.stone);
  };
  // from the floor west onto the first deck, along its free edge
  const Deck& first = plan.decks[0];
  const double z = 0.5 * (first.area.z0 + first.area.z1) + level.random.uniform(0.5, 1.5);
  add({first.area.x1 + 1.45 * first.floor_m, 0, z}, 180.0, first.floor_m);
  const Deck& second = plan.decks[1];
  // from the first deck north onto the second
  const double x = first.area.x0 + 0.5 * width + 0.1;
  const double rise = second.floor_m - first.floor_m;
  add({x, first.floor_m, second.area.z1 + 1.45 * rise}, 90.0, rise);
  // railings along free edges, with gaps where flights arrive
  addEdgeRailing(level, {first.area.x1 - 0.06, first.floor_m, first.area.z1}, 90.0, first.area.depth(),
                 first.area.z1 - z - 0.5 * width - 0.1, first.area.z1 - z + 0.5 * width + 0.1);
  addEdgeRailing(level, {second.area.x0, second.floor_m, second.area.z1 - 0.06}, 0.0, second.area.width(), 0.0, width + 0.3);
  if (plan.decks.size() > 2) {
    const Deck& third = plan.decks[2];
    const double step = third.floor_m - second.floor_m;
    add({third.area.x0 - 1.45 * step, second.floor_m, second.area.z0 + 0.5 * width + 0.2}, 0.0, step);
    addEdgeRailing(level, {third.area.x0 + 0.06, third.floor_m, third.area.z1}, 90.0, third.area.depth(),
                   third.area.depth() - width - 0.5, third.area.depth());
  }
}

void addFurnishing(Level& level, const StairPlan& plan) {
  const Rect in = plan.building.inner();
  for (const Deck& deck : plan.decks) {
    const int count = level.pickCount(1, 3);
    for (int i = 0; i < count; ++i) {
      const glm::dvec3 at{level.random.uniform(deck.area.x0 + 0.8, deck.area.x1 - 0.8), deck.floor_m,
                          level.random.uniform(deck.area.z0 + 0.8, deck.area.z1 - 0.8)};
      const Placement placement = facing(at, level.pick(0.0, 90.0));
      if (level.random.chance(0.5)) {
        addCrate(level, placement, level.pick(0.5, 0.9));
      } else {
        addBarrel(level, placement, level.pick(0.8, 1.1));
      }
    }
  }
  Room room{{0.0, 0.0, in.x1, in.z1}, 0.0, 3.0, plan.building.openingsOf(0)};
  furnishRoom(level, room, RoomUse::store, 0.35);
}

}  // namespace

void buildStairs(Level& level) {
  StairPlan plan = drawPlan(level);
  Building& building = plan.building;
  addGround(level, building, 2.0);
  fillShell(level, building);
  // rows of windows at every deck's height, besides those of the floor
  carveWindows(level, building, 0, 0.4);
  const Rect& out = building.outer;
  for (const Deck& deck : plan.decks) {
    const double low = deck.floor_m + 1.0;
    for (double x = out.x0 + 2.0; x < out.x1 - 2.5; x += 3.0) {
      if (level.random.chance(0.5)) building.shell.carve({x, low, out.z1 - building.wall_m}, {x + 1.0, low + 1.2, out.z1});
      if (level.random.chance(0.3)) building.shell.carve({x, low, out.z0}, {x + 1.0, low + 1.2, out.z0 + building.wall_m});
    }
  }
  carveDoor(building, Side::south, 0, 0.6 * building.inner().width(), level.pick(1.2, 2.2), 2.4);
  if (level.random.chance(0.4)) {  // a skylight
    const Rect in = building.inner().grown(-2.0);
    building.shell.carve({in.x0, building.clear_m[0], in.z0}, {in.x0 + 0.5 * in.width(), building.roofHeight(), in.z1});
  }
  building.shell.emitObject(level.mesh, "shell", Mobility::structure);
  for (const Deck& deck : plan.decks) addDeck(level, deck);
  addFlights(level, plan);
  // a spiral stair from the ground to the highest deck
  if (level.random.chance(0.6)) {
    const Deck& top = plan.decks.back();
    const Rect in = building.inner();
    const double radius = level.pick(0.9, 1.2);
    const bool is_east = plan.decks.size() > 2;
    const double x = is_east ? top.area.x0 - radius - 0.1 : std::min(top.area.x1, in.x1) - 3.0;
    const double z = is_east ? 0.5 * (top.area.z0 + top.area.z1) + 0.5 : top.area.z1 + radius + 0.1;
    addSpiral(level, {x, 0, z}, top.floor_m, radius);
  }
  addFurnishing(level, plan);
}

}  // namespace nlg
