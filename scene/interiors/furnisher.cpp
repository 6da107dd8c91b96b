#include "scene/interiors/furnisher.h"

#include <algorithm>
#include <cmath>

#include "scene/procedural/furniture.h"

namespace nlg {
namespace {

using Use = FurnitureUse;

glm::dvec3 gridded(const glm::dvec3& p) {
  return {snapped(p.x, kVerticesPerMetre), snapped(p.y, kVerticesPerMetre), snapped(p.z, kVerticesPerMetre)};
}

using Size = glm::dvec3;

// A tub: a block with a hollow.
void addTub(Home& home, const Placement& placement, const Size& size) {
  BrushGrid tub;
  const double x = 0.5 * size.x, z = 0.5 * size.z;
  tub.fill({-x, 0, -z}, {x, size.y, z}, home.porcelain_material);
  tub.carve({-x + 0.08, 0.15, -z + 0.08}, {x - 0.08, size.y, z - 0.08});
  tub.emitObject(home.level.mesh, "bath", Mobility::movable, placement);
}

// A bowl and a cistern.
void addToilet(Home& home, const Placement& placement, const Size& size) {
  BrushGrid bowl;
  const double x = 0.5 * size.x, z = 0.5 * size.z;
  bowl.fill({-0.6 * x, 0, -0.4 * z}, {0.6 * x, 0.3, 0.6 * z}, home.porcelain_material);
  bowl.fill({-x, 0.25, -0.45 * z}, {x, 0.41, z}, home.porcelain_material);
  bowl.carve({-0.65 * x, 0.3, -0.3 * z}, {0.65 * x, 0.41, 0.8 * z});
  bowl.fill({-x, 0.25, -z}, {x, size.y, -0.45 * z}, home.porcelain_material);
  bowl.emitObject(home.level.mesh, "toilet", Mobility::movable, placement);
}

// A tray, two panes of 8 mm, a door that stands half open.
void addShower(Home& home, const Placement& placement, const Size& size) {
  BrushGrid cabin;
  const double x = 0.5 * size.x, z = 0.5 * size.z, pane = 0.008;
  cabin.fill({-x, 0, -z}, {x, 0.1, z}, home.porcelain_material);
  cabin.fill({-x, 0.1, -z}, {-x + pane, size.y, z}, home.glass_material);
  cabin.fill({-x, 0.1, z - pane}, {0.1 * x, size.y, z}, home.glass_material);
  cabin.emitObject(home.level.mesh, "shower", Mobility::movable, placement);
}

using Emit = void (*)(Home&, const Placement&, const Size&);
template <void (*add)(Level&, const Placement&, const Size&)>
void ofLevel(Home& home, const Placement& at, const Size& size) {
  add(home.level, at, size);
}
constexpr Emit kTable = ofLevel<addTable>, kBed = ofLevel<addBed>, kSofa = ofLevel<addSofa>, kShelf = ofLevel<addShelf>;
constexpr Emit kCupboard = ofLevel<addCupboard>;
constexpr Emit kChair = [](Home& home, const Placement& at, const Size&) { addChair(home.level, at); };
constexpr Emit kCrate = [](Home& home, const Placement& at, const Size& s) { addCrate(home.level, at, s.x); };

// Procedural furniture for a use that a house cannot do without.
struct Procedural {
  Use use;
  Size size, more_a, more_b;  // metres, and what two draws from 0 to 1 add
  Emit emit;
  double elevation_m = 0.0;
};

const Procedural kProcedural[] = {{Use::bed, {0.9, 1.0, 2.0}, {0.9, 0, 0}, {0, 0, 0.15}, kBed},
                                  {Use::child_bed, {0.8, 0.95, 1.8}, {0.2, 0, 0}, {0, 0, 0.2}, kBed},
                                  {Use::sofa, {1.5, 0.85, 0.8}, {0.8, 0, 0}, {0, 0, 0.15}, kSofa},
                                  {Use::armchair, {0.75, 0.85, 0.8}, {0.2, 0, 0}, {0, 0, 0}, kSofa},
                                  {Use::dining_table, {1.2, 0.75, 0.8}, {0.8, 0, 0}, {0, 0, 0.2}, kTable},
                                  {Use::desk, {1.2, 0.74, 0.65}, {0.5, 0, 0}, {0, 0, 0.15}, kTable},
                                  {Use::coffee_table, {0.8, 0.42, 0.5}, {0.5, 0, 0}, {0, 0, 0.2}, kTable},
                                  {Use::chair, {0.44, 0.95, 0.44}, {0, 0, 0}, {0, 0, 0}, kChair},
                                  {Use::office_chair, {0.44, 0.95, 0.44}, {0, 0, 0}, {0, 0, 0}, kChair},
                                  {Use::wardrobe, {1.0, 1.9, 0.6}, {0.8, 0, 0}, {0, 0.2, 0}, kCupboard},
                                  {Use::chest, {0.9, 0.7, 0.45}, {0.6, 0, 0}, {0, 0.2, 0}, kCupboard},
                                  {Use::tv_stand, {0.9, 0.5, 0.45}, {0.6, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::bookcase, {0.8, 1.2, 0.32}, {1.0, 0, 0}, {0, 0.8, 0}, kShelf},
                                  {Use::bedside, {0.42, 0.5, 0.4}, {0, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::filing, {0.4, 0.7, 0.55}, {0, 0, 0}, {0, 0.6, 0}, kCupboard},
                                  {Use::kitchen_base, {0.6, 0.88, 0.6}, {0, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::kitchen_sink, {0.6, 0.88, 0.6}, {0, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::cooker, {0.6, 0.88, 0.6}, {0, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::laundry, {0.6, 0.88, 0.6}, {0, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::kitchen_wall, {0.6, 0.7, 0.35}, {0, 0, 0}, {0, 0, 0}, kCupboard, 1.45},
                                  {Use::fridge, {0.6, 1.5, 0.62}, {0, 0, 0}, {0, 0.5, 0}, kCupboard},
                                  {Use::washbasin, {0.55, 0.85, 0.45}, {0, 0, 0}, {0, 0, 0}, kCupboard},
                                  {Use::bath, {1.7, 0.58, 0.75}, {0, 0, 0}, {0, 0, 0}, addTub},
                                  {Use::toilet, {0.38, 0.8, 0.66}, {0, 0, 0}, {0, 0, 0}, addToilet},
                                  {Use::shower, {0.85, 2.0, 0.85}, {0, 0, 0}, {0, 0, 0}, addShower},
                                  {Use::storage, {0.5, 0.5, 0.5}, {0.3, 0.3, 0.3}, {0, 0, 0}, kCrate}};

const Procedural* proceduralOf(Use use) {
  const auto found = std::find_if(std::begin(kProcedural), std::end(kProcedural), [&](const auto& p) { return p.use == use; });
  return found != std::end(kProcedural) ? found : nullptr;
}

void addLibraryModel(Home& home, const Piece& piece, const Placement& placement) {
  MeshBuilder& mesh = home.level.mesh;
  const FurnitureModel& model = *piece.model;
  // all copies of a model share its materials
  const auto found = home.first_material.find(&model);
  uint32_t first_material = found == home.first_material.end() ? 0 : found->second;
  if (found == home.first_material.end()) {
    for (size_t i = 0; i < model.materials.size(); ++i) {
      const uint32_t added = mesh.addMaterial(model.materials[i]);
      if (i == 0) first_material = added;
    }
    home.first_material[&model] = first_material;
  }
  mesh.beginObject(piece.name, Mobility::movable);
  // the model's indices count from its own first vertex
  uint32_t first_vertex = 0;
  for (size_t i = 0; i < model.positions.size(); ++i) {
    const uint32_t added = mesh.addVertex(placement, model.positions[i]);
    if (i == 0) first_vertex = added;
  }
  for (size_t i = 0; i < model.triangles.size(); ++i) {
    const glm::uvec3 t = model.triangles[i] + first_vertex;
    mesh.addTriangle(t.x, t.y, t.z, first_material + model.triangle_material[i]);
  }
}

// Where the light of a lamp of the library is: outside of its shade, which is opaque here.
void addLight(Home& home, const Piece& piece, const Placement& placement) {
  const bool hangs = piece.use == Use::hanging_lamp || piece.use == Use::ceiling_lamp;
  const bool stands = piece.use == Use::floor_lamp || piece.use == Use::table_lamp;
  if (!hangs && !stands && piece.use != Use::wall_lamp) return;
  const double warmth = home.level.random.uniform();
  const double strength = home.level.random.uniform(0.6, 1.8) * (hangs ? 1.5 : 0.5);
  Lamp lamp;
  const glm::dvec3 local = hangs    ? glm::dvec3(0.0, -0.08, 0.0)
                           : stands ? glm::dvec3(0.0, piece.size_m.y + 0.08, 0.0)
                                    : glm::dvec3(0.0, 0.5 * piece.size_m.y, 0.5 * piece.size_m.z + 0.08);
  lamp.position = glm::vec3(gridded(placement.apply(local)));
  lamp.intensity = glm::vec3(glm::dvec3(1.0, 0.95 - 0.2 * warmth, 0.9 - 0.5 * warmth) * strength);
  lamp.radius_m = 0.05f;
  home.lamps.push_back(lamp);
}

bool isWithin(const Piece& piece, const MostSize& most) {
  return piece.size_m.x <= most.width_m && piece.size_m.z <= most.depth_m && piece.size_m.y + piece.elevation_m <= most.height_m;
}

// The middle of the piece along the wall's strip and the angle, as a footprint.
Stood atWall(const HomeRoom& room, const Piece& piece, Side side, double along, double gap_m) {
  const double degrees = degreesAt(side);
  const double half = 0.5 * piece.size_m.x;
  const Rect area = room.floor.strip(side, along - half, along + half, gap_m + piece.size_m.z, gap_m);
  const glm::dvec2 middle = area.middle();
  const Placement placement{gridded({middle.x, room.floor_m + piece.elevation_m, middle.y}), turnByDegrees(degrees)};
  return {piece, placement, area, degrees, side};
}

Box boxOf(const Stood& stood) {
  const double low = stood.placement.position.y;
  return {stood.area, low, low + stood.piece.size_m.y};
}

void settle(Home& home, HomeRoom& room, const Stood& stood) {
  room.solids.push_back(boxOf(stood));
  emitPiece(home, stood.piece, stood.placement);
}

}  // namespace

std::optional<Piece> drawPiece(Home& home, Use use, const MostSize& most) {
  // pieces of the catalogue that fit by their size
  std::vector<size_t> fitting;
  for (const size_t i : home.library.pieces(use)) {
    const glm::dvec3& size = home.library.entry(i).size_m;
    const Piece piece{use, size, home.library.entry(i).elevation_m, 0.0, nullptr, ""};
    if (isWithin(piece, most) && size.x < most.width_m) fitting.push_back(i);
  }
  // a model that cannot be read, or is too fine, gives way to another
  for (int attempt = 0; attempt < 4 && !fitting.empty(); ++attempt) {
    const size_t i = fitting[home.level.random.below(static_cast<uint32_t>(fitting.size()))];
    const FurnitureModel* model = home.library.model(i);
    if (model == nullptr) continue;
    const CatalogueEntry& entry = home.library.entry(i);
    return Piece{use, entry.size_m, entry.elevation_m, entry.top_m, model, entry.name};
  }
  const double a = home.level.pick(0.0, 1.0), b = home.level.pick(0.0, 1.0);  // one draw each, whatever the use
  // else a piece of boxes, if there is one for this use
  const Procedural* made = proceduralOf(use);
  if (made == nullptr) return std::nullopt;
  const Size size = made->size + a * made->more_a + b * made->more_b;
  const Piece piece{use, size, made->elevation_m, size.y, nullptr, ""};
  return isWithin(piece, most) ? std::optional(piece) : std::nullopt;
}

void emitPiece(Home& home, const Piece& piece, const Placement& placement) {
  if (piece.model == nullptr) return proceduralOf(piece.use)->emit(home, placement, piece.size_m);
  addLibraryModel(home, piece, placement);
  addLight(home, piece, placement);
}

std::optional<Stood> standAtWall(Home& home, HomeRoom& room, const Piece& piece, const WallWish& wish) {
  Random& random = home.level.random;
  const double half = 0.5 * piece.size_m.x;
  for (int attempt = 0; attempt < 30; ++attempt) {
    // each attempt draws the same numbers, used or not
    const Side drawn = kSides[random.below(4)];
    const double share = random.uniform();
    const bool to_corner = random.chance(0.35);
    const Side side = wish.side.value_or(drawn);
    const double first = room.floor.start(side) + half + wish.gap_m, slack = room.floor.length(side) - 2.0 * (half + wish.gap_m);
    constexpr double kHanging = 0.3;  // what is higher than this above the floor needs a wall
    if (slack < 0.0 || (piece.elevation_m > kHanging && !room.hasWall(side))) continue;
    const double free_choice = first + slack * (to_corner ? (share < 0.5 ? 0.0 : 1.0) : share);
    // a wished place is left by 15 cm at most
    const double along =
        wish.at ? std::clamp(*wish.at + (attempt == 0 ? 0.0 : 0.3 * (share - 0.5)), first, first + slack) : free_choice;
    const Stood stood = atWall(room, piece, side, along, wish.gap_m);
    if (!room.isFree(boxOf(stood))) continue;
    // the room before a piece is empty, and stays so
    const Box access{room.floor.strip(side, along - half, along + half, wish.gap_m + piece.size_m.z + wish.access_m),
                     stood.placement.position.y, stood.placement.position.y + std::min(1.8, piece.size_m.y)};
    if (!room.isEmpty(access)) continue;
    if (wish.access_m > 0.0) room.kept.push_back(access);
    settle(home, room, stood);
    return stood;
  }
  return std::nullopt;
}

std::optional<Stood> addAtWall(Home& home, HomeRoom& room, Use use, const WallWish& wish) {
  return addAtWall(home, room, use, {4.0, 4.0, room.clear_m}, wish);
}

std::optional<Stood> addAtWall(Home& home, HomeRoom& room, Use use, const MostSize& most, const WallWish& wish) {
  const std::optional<Piece> piece = drawPiece(home, use, most);
  return piece ? standAtWall(home, room, *piece, wish) : std::nullopt;
}

Rect footprint(const Piece& piece, const glm::dvec2& middle, double degrees) {
  const Turn turn = turnByDegrees(degrees);
  const double c = std::abs(turn.cosine), s = std::abs(turn.sine);
  const double x = 0.5 * (c * piece.size_m.x + s * piece.size_m.z), z = 0.5 * (s * piece.size_m.x + c * piece.size_m.z);
  return {middle.x - x, middle.y - z, middle.x + x, middle.y + z};
}

std::optional<Stood> standFree(Home& home, HomeRoom& room, const Piece& piece, const glm::dvec2& middle, double degrees,
                               double margin_m) {
  const Placement placement{gridded({middle.x, room.floor_m + piece.elevation_m, middle.y}), turnByDegrees(degrees)};
  const Stood stood{piece, placement, footprint(piece, middle, degrees), degrees, Side::north};
  Box around = boxOf(stood);
  if (!room.isFree(around)) return std::nullopt;
  around.area = around.area.grown(margin_m);
  if (!room.isEmpty(around)) return std::nullopt;
  settle(home, room, stood);
  return stood;
}

std::optional<Stood> standAnywhere(Home& home, HomeRoom& room, const Piece& piece, double margin_m) {
  Random& random = home.level.random;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const double x = random.uniform(room.floor.x0, room.floor.x1);
    const double z = random.uniform(room.floor.z0, room.floor.z1);
    const double degrees = random.uniform(0.0, 360.0);
    std::optional<Stood> stood = standFree(home, room, piece, {x, z}, degrees, margin_m);
    if (stood) return stood;
  }
  return std::nullopt;
}

std::optional<Stood> addAnywhere(Home& home, HomeRoom& room, Use use, const MostSize& most, double margin_m) {
  const std::optional<Piece> piece = drawPiece(home, use, most);
  return piece ? standAnywhere(home, room, *piece, margin_m) : std::nullopt;
}

void putOnTop(Home& home, const std::optional<Stood>& stood, const std::vector<Use>& uses, int count) {
  if (!stood || stood->piece.top_m <= 0.0) return;
  const Stood& below = *stood;
  Random& random = home.level.random;
  // footprints in the frame of the piece below, origin at its middle
  std::vector<Rect> taken;
  const glm::dvec3& size = below.piece.size_m;
  for (int i = 0; i < count; ++i) {
    const Use use = uses[random.below(static_cast<uint32_t>(uses.size()))];
    const std::optional<Piece> piece = drawPiece(home, use, {0.8 * size.x, 0.8 * size.z, 1.0});
    // position as a share of what the footprint leaves free, 3 cm from every edge
    const double x = random.uniform(-0.5, 0.5), z = random.uniform(-0.5, 0.5);
    const double turn = random.chance(0.5) ? 0.0 : random.uniform(-40.0, 40.0);
    if (!piece || piece->model == nullptr) continue;
    const Rect local = footprint(*piece, {0.0, 0.0}, turn);
    const glm::dvec2 at{x * std::max(0.0, size.x - local.width() - 0.06), z * std::max(0.0, size.z - local.depth() - 0.06)};
    const Rect area = footprint(*piece, at, turn);
    // a turned piece may still reach over the edge
    const Rect top{-0.5 * size.x, -0.5 * size.z, 0.5 * size.x, 0.5 * size.z};
    if (area.x0 < top.x0 || area.x1 > top.x1 || area.z0 < top.z0 || area.z1 > top.z1) continue;
    if (std::any_of(taken.begin(), taken.end(), [&](const Rect& other) { return other.overlaps(area); })) continue;
    taken.push_back(area);
    // from the frame of the top to that of the home
    Placement placement = below.placement;
    placement.position = gridded(below.placement.apply({at.x, below.piece.top_m, at.y}));
    placement.turn = turnByDegrees(below.degrees + turn);
    emitPiece(home, *piece, placement);
  }
}

void hangLamp(Home& home, HomeRoom& room, const glm::dvec2& middle) {
  if (!room.has_ceiling) return;
  const Use use = home.level.random.chance(0.7) ? Use::hanging_lamp : Use::ceiling_lamp;
  const double ceiling = room.floor_m + room.clear_m;
  std::optional<Piece> piece = drawPiece(home, use, {2.0, 2.0, 4.0});
  if (!piece) piece = drawPiece(home, Use::ceiling_lamp, {2.0, 2.0, 4.0});
  // nobody is to run into it
  if (!piece || piece->size_m.y > room.clear_m - 1.5) return addCeilingLamp(home.level, {{middle.x, ceiling, middle.y}, {}});
  const glm::dvec3 foot = gridded({middle.x, ceiling, middle.y}) - glm::dvec3(0.0, piece->size_m.y, 0.0);
  const Box box{footprint(*piece, middle, 0.0), foot.y, ceiling};
  if (!room.isEmpty(box)) return;
  room.solids.push_back(box);
  emitPiece(home, *piece, {foot, {}});
}

}  // namespace nlg
