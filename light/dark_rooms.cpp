#include "light/dark_rooms.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "light/standing.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

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

// Where an eye is, or nothing in what is no room.
std::optional<glm::dvec3> eyeIn(const std::vector<uint32_t>& room, const std::vector<glm::dvec3>& places, const Spots& spots,
                                const RayScene& rays) {
  const size_t step = std::max<size_t>(1, room.size() / kAskedPlaces);
  std::optional<glm::dvec3> eye;
  for (size_t i = 0; i < room.size(); i += step) {
    const glm::dvec3& place = places[room[i]];
    if (rays.lightHit(glm::vec3(place), {0.0f, 1.0f, 0.0f}).kind != LightHit::Kind::surface) return std::nullopt;
    if (eye) continue;
    const std::optional<Spot> spot = spots.below(place);
    if (spot && spot->is_upright && spot->has_roof) eye = spot->eye_m;
  }
  return eye;
}

}  // namespace

std::vector<DarkRoom> findDarkRooms(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& air,
                                    const std::vector<uint8_t>& is_dark) {
  std::vector<DarkRoom> rooms;
  if (std::find(is_dark.begin(), is_dark.end(), 1) == is_dark.end()) return rooms;
  DarkAir dark(transport.rays(), air.places, is_dark, tree.frame().spacing_m);
  std::unordered_map<uint32_t, std::vector<uint32_t>> places_of;  // by root
  for (uint32_t p = 0; p < is_dark.size(); ++p) {
    if (is_dark[p] && !dark.touchesLight(dark.rootOf(p))) places_of[dark.rootOf(p)].push_back(p);
  }
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
