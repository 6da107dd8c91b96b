// A dark room is a component of dark sample points that see each other: union-find over pairs in neighbouring cubes of the reach.
#include "light/standing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "light/air.h"
#include "light/directions.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr float kWalkableSlope = 0.7f;                  // of the floor's normal: 45 degrees, as games have it
constexpr double kUprightM = kEyeHeightM + kOverEyesM;  // below it nobody stands upright
constexpr double kLeastHeadroomM = 0.5;                 // below it nobody looks out
constexpr double kElbowRoomM = 0.25;                    // around an eye
constexpr double kStrideM = 0.6, kStepM = 0.3;          // around a place to stand: no table, no ledge
constexpr int kTurns = 8;                               // around the vertical

glm::dvec3 around(int turn) {
  const double angle = 2.0 * std::numbers::pi * turn / kTurns;
  return {std::cos(angle), 0.0, std::sin(angle)};
}

constexpr uint64_t kLookStream = 0x766f6964;
constexpr int kTries = 4;             // of a place, to see another part of the air around it
constexpr size_t kAskedPlaces = 200;  // of a room, for a roof and a place to stand
constexpr size_t kFewestPlaces = 8;   // of a room: fewer may be dark, and see no light, by chance

// Dark places that see each other from near are joined.
class DarkAir {
 public:
  DarkAir(const RayScene& rays, const std::vector<glm::dvec3>& places, const std::vector<uint8_t>& is_dark, double reach_m)
      : rays_(rays), places_(places), is_dark_(is_dark), reach_m_(reach_m), parent_(places.size()), is_lit_(places.size(), 0) {
    std::iota(parent_.begin(), parent_.end(), 0U);
    for (uint32_t p = 0; p < places.size(); ++p) cubes_[keyOf(cubeOf(p))].push_back(p);
    for (uint32_t p = 0; p < places.size(); ++p) {
      if (is_dark[p]) joinAround(p);
    }
  }

  uint32_t rootOf(uint32_t place) {
    while (parent_[place] != place) place = parent_[place] = parent_[parent_[place]];
    return place;
  }
  bool touchesLight(uint32_t root) const { return is_lit_[root]; }

 private:
  void joinAround(uint32_t place) {
    // few rays towards each room: more would look at the same air again
    std::vector<std::pair<uint32_t, int>> tried;  // by root; of lit places together
    const auto mayTry = [&](uint32_t root) {
      auto found = std::find_if(tried.begin(), tried.end(), [&](const auto& entry) { return entry.first == root; });
      if (found == tried.end()) found = tried.emplace(tried.end(), root, 0);
      return ++found->second <= kTries;
    };
    const glm::i64vec3 centre = cubeOf(place);
    for (int i = 0; i < 27; ++i) {
      const auto cube = cubes_.find(keyOf(centre + glm::i64vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (cube == cubes_.end()) continue;
      for (const uint32_t other : cube->second) {
        const uint32_t own = rootOf(place), root = is_dark_[other] ? rootOf(other) : kLit;
        if (own == root || (root == kLit && is_lit_[own]) || !mayTry(root)) continue;
        if (rays_.isBlocked(glm::vec3(places_[place]), glm::vec3(places_[other]))) continue;
        // lit air joins no room, but the room that sees it is not dark
        if (root == kLit) {
          is_lit_[own] = 1;
        } else {
          parent_[own] = root;
          is_lit_[root] |= is_lit_[own];
        }
      }
    }
  }

  glm::i64vec3 cubeOf(uint32_t place) const { return glm::i64vec3(glm::floor(places_[place] / reach_m_)); }
  static uint64_t keyOf(const glm::i64vec3& cube) {
    return mixSeed(static_cast<uint64_t>(cube.x), static_cast<uint64_t>(cube.y), static_cast<uint64_t>(cube.z));
  }

  static constexpr uint32_t kLit = 0xffffffff;
  const RayScene& rays_;
  const std::vector<glm::dvec3>& places_;
  const std::vector<uint8_t>& is_dark_;
  const double reach_m_;
  std::vector<uint32_t> parent_;  // by place
  std::vector<uint8_t> is_lit_;   // by root
  std::unordered_map<uint64_t, std::vector<uint32_t>> cubes_;
};

// Calls visit(place) for places of a room, evenly, until it says that it knows enough.
template <class Visit>
void askPlaces(const std::vector<uint32_t>& room, const Visit& visit) {
  const size_t step = std::max<size_t>(1, room.size() / kAskedPlaces);
  for (size_t i = 0; i < room.size() && !visit(room[i]); i += step) {
  }
}

// Where an eye is, or nothing in what is no room.
std::optional<glm::dvec3> eyeIn(const std::vector<uint32_t>& room, const std::vector<glm::dvec3>& places, const Spots& spots,
                                const RayScene& rays) {
  bool is_open = false;
  std::optional<glm::dvec3> eye;
  askPlaces(room, [&](uint32_t p) {
    is_open = rays.lightHit(glm::vec3(places[p]), {0.0f, 1.0f, 0.0f}).kind != LightHit::Kind::surface;
    const std::optional<Spot> spot = eye || is_open ? std::nullopt : spots.below(places[p]);
    if (spot && spot->is_upright && spot->has_roof) eye = spot->eye_m;
    return is_open;
  });
  return is_open ? std::nullopt : eye;
}

// Whether more than half of what is around a place is nothing: beyond walls, and on a roof.
bool isInTheVoid(const RayScene& rays, const glm::dvec3& place) {
  constexpr int kLooks = 32;
  const Lattice directions(kLookStream);
  int nothing = 0;
  for (int i = 0; i < kLooks; ++i) {
    const auto [u, v] = directions.point(i, kLooks);
    nothing += rays.lightHit(glm::vec3(place), sphereDirection(u, v)).kind == LightHit::Kind::nothing;
  }
  return 2 * nothing > kLooks;
}

}  // namespace

bool Spots::isInExtent(const glm::dvec3& place_m) const {
  return glm::all(glm::greaterThanEqual(place_m, extent_.low_m)) && glm::all(glm::lessThanEqual(place_m, extent_.high_m));
}

std::optional<Spot> Spots::below(const glm::dvec3& place_m) const {
  const LightHit floor = rays_.lightHit(glm::vec3(place_m), {0.0f, -1.0f, 0.0f});
  if (!isFloor(floor)) return std::nullopt;
  Spot spot;
  spot.floor_m = place_m - glm::dvec3(0.0, floor.distance, 0.0);
  const glm::dvec3 off_floor = spot.floor_m + glm::dvec3(0.0, transport_.nudge(), 0.0);
  const LightHit ceiling = rays_.lightHit(glm::vec3(off_floor), {0.0f, 1.0f, 0.0f});
  spot.headroom_m = ceiling.kind == LightHit::Kind::nothing ? std::numeric_limits<double>::infinity() : double{ceiling.distance};
  spot.has_roof = ceiling.kind == LightHit::Kind::surface;
  if (spot.headroom_m < kLeastHeadroomM) return std::nullopt;
  spot.eye_m = spot.floor_m + glm::dvec3(0.0, std::min(kEyeHeightM, spot.headroom_m - kOverEyesM), 0.0);
  if (!isInExtent(spot.eye_m) || !isInAir(rays_, spot.eye_m)) return std::nullopt;
  for (int turn = 0; turn < kTurns; ++turn) {
    if (isBlocked(spot.eye_m, spot.eye_m + kElbowRoomM * around(turn))) return std::nullopt;
  }
  if (spot.headroom_m < kUprightM && !isLowAround(spot)) return std::nullopt;
  spot.is_upright = spot.headroom_m >= kUprightM && isFreeOfFigure(spot.floor_m);
  spot.is_wide = isWide(spot);
  return spot;
}

bool Spots::isFloor(const LightHit& hit) const {
  if (hit.kind != LightHit::Kind::surface || hit.normal.y < kWalkableSlope) return false;
  const Scene& scene = transport_.scene();
  return hit.is_front || scene.materials[scene.triangle_material[hit.triangle]].double_sided;
}

bool Spots::isFreeOfFigure(const glm::dvec3& floor_m) const {
  constexpr double kTouching = 0.95;  // of a radius: the lowest ball lies on the floor
  for (const FigureBall& ball : kFigure) {
    const glm::dvec3 centre = floor_m + glm::dvec3(0.0, ball.height_m, 0.0), up(0.0, kTouching * ball.radius_m, 0.0);
    if (!isInExtent(centre) || isBlocked(centre - up, centre + up)) return false;
    for (int turn = 0; turn < kTurns; ++turn) {
      if (isBlocked(centre, centre + kTouching * ball.radius_m * around(turn))) return false;
    }
    if (!isInAir(rays_, centre)) return false;
  }
  return true;
}

bool Spots::isLowAround(const Spot& spot) const {
  for (int turn = 0; turn < kTurns; ++turn) {
    const glm::dvec3 beside = spot.eye_m + kStrideM * around(turn);
    if (isBlocked(spot.eye_m, beside)) continue;
    if (!isBlocked(beside, {beside.x, spot.floor_m.y + kUprightM, beside.z})) return false;
  }
  return true;
}

bool Spots::isWide(const Spot& spot) const {
  int free = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    const glm::dvec3 beside = spot.eye_m + kStrideM * around(turn);
    if (isBlocked(spot.eye_m, beside)) continue;
    ++free;
    const LightHit hit = rays_.lightHit(glm::vec3(beside), {0.0f, -1.0f, 0.0f});
    if (!isFloor(hit) || std::abs(beside.y - hit.distance - spot.floor_m.y) > kStepM) return false;
  }
  return free >= kTurns / 2;
}

std::vector<uint8_t> findUnseenDark(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                    std::vector<uint8_t> is_dark, double reach_m) {
  std::vector<uint8_t> is_unseen(places.size(), 0);
  if (std::find(is_dark.begin(), is_dark.end(), 1) == is_dark.end()) return is_unseen;
  const RayScene& rays = transport.rays();
  const bool has_void = !rays.hasSkyFaces() && !hasLightFromOutside(transport.scene());
  // the void joins nothing: through it a hollow would be one with a dark yard
  for (uint32_t p = 0; p < is_dark.size() && has_void; ++p) {
    if (!is_dark[p] || !isInTheVoid(rays, places[p])) continue;
    is_unseen[p] = 1;
    is_dark[p] = 0;
  }
  DarkAir dark(rays, places, is_dark, reach_m);
  std::unordered_map<uint32_t, std::vector<uint32_t>> regions;  // by root; what is said of each depends on no other
  for (uint32_t p = 0; p < is_dark.size(); ++p) {
    if (is_dark[p]) regions[dark.rootOf(p)].push_back(p);
  }
  const Spots spots(transport, {glm::dvec3(-INFINITY), glm::dvec3(INFINITY)});
  for (const auto& [root, region] : regions) {
    bool is_seen = false;
    askPlaces(region, [&](uint32_t p) {
      const std::optional<Spot> spot = spots.below(places[p]);
      is_seen = spot && spot->is_upright && !(has_void && isInTheVoid(rays, spot->eye_m));
      return is_seen;
    });
    for (const uint32_t p : region) is_unseen[p] = !is_seen;
  }
  return is_unseen;
}

std::vector<DarkRoom> findDarkRooms(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& air,
                                    const std::vector<uint8_t>& is_dark) {
  std::vector<DarkRoom> rooms;
  if (std::find(is_dark.begin(), is_dark.end(), 1) == is_dark.end()) return rooms;
  DarkAir dark(transport.rays(), air.places, is_dark, air.spacing_m);
  // a dark room: dark points joined by sight, none of which sees a lit one
  std::unordered_map<uint32_t, std::vector<uint32_t>> places_of;  // by root
  for (uint32_t p = 0; p < is_dark.size(); ++p) {
    if (is_dark[p] && !dark.touchesLight(dark.rootOf(p))) places_of[dark.rootOf(p)].push_back(p);
  }
  // the air that each point stands for
  std::vector<double> volume_m3(air.places.size(), 0.0);
  for (const AirPlaces::Cell& of_cell : air.cells) {
    const double side_m = tree.frame().spacing_m * of_cell.cell.side;
    for (uint32_t p = of_cell.first; p < of_cell.first + of_cell.count; ++p)
      volume_m3[p] = side_m * side_m * side_m * of_cell.air_share / of_cell.count;
  }
  const Spots spots(transport, {glm::dvec3(-INFINITY), glm::dvec3(INFINITY)});
  std::vector<std::vector<uint32_t>> candidates;
  candidates.reserve(places_of.size());
  for (auto& [root, places] : places_of) candidates.push_back(std::move(places));
  std::sort(candidates.begin(), candidates.end());  // as places are, whatever the map's order
  for (const std::vector<uint32_t>& places : candidates) {
    if (places.size() < kFewestPlaces) continue;
    const std::optional<glm::dvec3> eye = eyeIn(places, air.places, spots, transport.rays());
    if (!eye) continue;
    DarkRoom& room = rooms.emplace_back(DarkRoom{*eye, 0.0});
    for (const uint32_t p : places) room.volume_m3 += volume_m3[p];
  }
  std::stable_sort(rooms.begin(), rooms.end(), [](const DarkRoom& a, const DarkRoom& b) { return a.volume_m3 > b.volume_m3; });
  return rooms;
}

}  // namespace nlg
