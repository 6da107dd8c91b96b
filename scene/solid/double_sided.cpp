#include "scene/solid/double_sided.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/solid/closed_shells.h"
#include "scene/solid/inscribed_ball.h"

namespace nlg {
namespace {

// Of the area: what rays seldom find is closed, as cracks along the edges of cut faces are. Up to the second, artists may have left
// out faces that nobody sees, or cut a door.
constexpr double kHoleShare = 1e-3, kLargeHoleShare = 0.05;
constexpr double kThinnest = 1e-6;       // volume over area and diagonal: below, a sheet with a front and a back
constexpr uint32_t kPointsPerPart = 16;  // that say where a part lies
constexpr uint32_t kMostParts = 65536;   // that may lie in others: the largest
constexpr double kMostInside = 0.75;     // of a part's points: so much in a shell, it lies in it. Feet sink into floors
constexpr double kTouch_m = 1e-3;        // along the line below: a point that lies on a shell is neither in it nor outside
// Of the scene's box, a shell and its box: what fills more is a room that is all there is, not a solid without a place in air.
constexpr double kMostOfScene = 0.5, kWholeScene = 0.9;
constexpr uint64_t kMostTests = uint64_t{1} << 33;
constexpr uint64_t kMostBallTests = uint64_t{1} << 26;  // of a scene: by then it is held that a ball fits
constexpr size_t kNamedObjects = 3;

constexpr uint32_t kAbsent = ~0u;

bool isDoubleSided(const Material& material) { return material.double_sided && material.transmissive == Transmissive::none; }

// A connected component of an object.
struct Part {
  uint32_t object = 0;
  Shell shell;
  uint32_t first = 0, count = 0;  // of its triangles in Parts::triangles

  bool hasHoles() const { return shell.hole_area_m2 > kHoleShare * shell.area_m2; }
  bool isShell() const {
    return shell.hole_area_m2 <= kLargeHoleShare * shell.area_m2 &&
           std::abs(shell.volume_m3) > kThinnest * shell.area_m2 * glm::length(shell.high - shell.low);
  }
  bool isOutward() const { return isShell() && shell.volume_m3 > 0.0; }
  bool isInward() const { return isShell() && shell.volume_m3 < 0.0; }
};

struct Parts {
  std::vector<Part> all;
  std::vector<uint32_t> triangles;  // of the scene, part by part, transmissive surfaces left out
  std::vector<uint32_t> same_as;    // by vertex
};

Parts partsOf(const Scene& scene) {
  Parts parts;
  std::vector<glm::vec3> positions = scene.positions;
  for (glm::vec3& p : positions) p += 0.0f;  // -0 is 0
  parts.same_as = weldedVertices(positions);
  ShellFinder finder(parts.same_as);
  for (size_t o = 0; o < scene.objects.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    // faces with alpha are sheets in any case, and close no shell
    std::vector<uint32_t> kept;
    std::vector<glm::uvec3> triangles;
    for (uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
      if (scene.materials[scene.triangle_material[i]].transmissive != Transmissive::none) continue;
      kept.push_back(i);
      triangles.push_back(scene.triangles[i]);
    }
    const Components components = finder.components(triangles);
    const size_t first_part = parts.all.size();
    for (const Shell& shell : finder.measure(positions, triangles, components))
      parts.all.push_back({static_cast<uint32_t>(o), shell});
    // counting sort by part
    for (const uint32_t component : components.of_triangle) ++parts.all[first_part + component].count;
    auto first = static_cast<uint32_t>(parts.triangles.size());
    for (size_t i = first_part; i < parts.all.size(); ++i) {
      parts.all[i].first = first;
      first += parts.all[i].count;
    }
    parts.triangles.resize(first);
    std::vector<uint32_t> filled(components.count, 0);
    for (size_t i = 0; i < kept.size(); ++i) {
      const uint32_t component = components.of_triangle[i];
      parts.triangles[parts.all[first_part + component].first + filled[component]++] = kept[i];
    }
  }
  return parts;
}

// Coordinates in which the lines that are looked along are vertical. They lean, since walls and edges of levels are upright.
glm::dvec3 leaning(const glm::vec3& p) { return {p.x - 0.2371 * p.y, p.z - 0.1713 * p.y, p.y}; }

// What may lie in a shell: a part, a lamp, a viewpoint.
struct Thing {
  uint32_t part = kAbsent;
  uint32_t point_count = 0;
  uint32_t container = kAbsent;  // the smallest shell around it
  bool is_outside = true;        // of all shells, as far as any of its points says
};

struct Point {
  glm::dvec3 at;  // leaning
  uint32_t thing;
};

// Points spread evenly over a part's area.
void addPoints(const Scene& scene, const Parts& parts, const Part& part, uint32_t thing, std::vector<Point>* points) {
  double passed = 0.0;
  uint32_t made = 0;
  for (uint32_t i = 0; i < part.count && made < kPointsPerPart; ++i) {
    const glm::uvec3& t = scene.triangles[parts.triangles[part.first + i]];
    const glm::dvec3 a(scene.positions[t.x]), b(scene.positions[t.y]), c(scene.positions[t.z]);
    passed += 0.5 * glm::length(glm::cross(b - a, c - a));
    for (; made < kPointsPerPart && (made + 0.5) / kPointsPerPart * part.shell.area_m2 <= passed; ++made) {
      // the golden ratio's two-dimensional sequence, folded onto the triangle
      double s = std::fmod(0.5 + 0.7548776662466927 * made, 1.0), r = std::fmod(0.5 + 0.5698402909980532 * made, 1.0);
      if (s + r > 1.0) s = 1.0 - s, r = 1.0 - r;
      points->push_back({leaning(glm::vec3(a + s * (b - a) + r * (c - a))), thing});
    }
  }
}

// Points by cells of a square grid over the first two of their leaning coordinates.
class PointGrid {
 public:
  explicit PointGrid(std::vector<Point> points) {
    side_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(points.size()))), 1, 1024);
    low_ = high_ = points.empty() ? glm::dvec2(0.0) : glm::dvec2(points[0].at);
    for (const Point& point : points) {
      low_ = glm::min(low_, glm::dvec2(point.at));
      high_ = glm::max(high_, glm::dvec2(point.at));
    }
    starts_.assign(static_cast<size_t>(side_) * side_ + 1, 0);
    for (const Point& point : points) ++starts_[cellOf(point.at) + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    std::vector<uint32_t> next(starts_.begin(), starts_.end() - 1);
    points_.resize(points.size());
    for (const Point& point : points) points_[next[cellOf(point.at)]++] = point;
  }

  const std::vector<Point>& points() const { return points_; }

  // Calls with the first and the last but one of points, for every row of cells that the box meets.
  template <class Visit>
  void visitRows(const glm::dvec2& low, const glm::dvec2& high, const Visit& visit) const {
    if (high.x < low_.x || high.y < low_.y || low.x > high_.x || low.y > high_.y) return;
    const size_t first = column(low, 0), last = column(high, 0);
    for (size_t row = column(low, 1); row <= column(high, 1); ++row)
      visit(starts_[row * side_ + first], starts_[row * side_ + last + 1]);
  }

 private:
  size_t column(const glm::dvec2& p, int axis) const {
    const double share = high_[axis] > low_[axis] ? (p[axis] - low_[axis]) / (high_[axis] - low_[axis]) : 0.0;
    return static_cast<size_t>(std::clamp(share * side_, 0.0, side_ - 1.0));
  }
  size_t cellOf(const glm::dvec2& p) const { return column(p, 1) * side_ + column(p, 0); }

  int side_ = 1;
  glm::dvec2 low_, high_;
  std::vector<uint32_t> starts_;
  std::vector<Point> points_;
};

// One triangle of a shell against vertical lines. Neighbours ask the same question of their common edge, bit for bit, so that a line
// passes as many faces of a closed shell upward as downward.
class Face {
 public:
  Face(const Scene& scene, const Parts& parts, const glm::uvec3& triangle) {
    for (int k = 0; k < 3; ++k) {
      id_[k] = parts.same_as[triangle[k]];
      at_[k] = leaning(scene.positions[triangle[k]]);
    }
    normal_ = glm::cross(at_[1] - at_[0], at_[2] - at_[0]);
    low = glm::min(at_[0], glm::min(at_[1], at_[2]));
    high = glm::max(at_[0], glm::max(at_[1], at_[2]));
  }

  // 1: the line through the point meets it on its way out of what it encloses, upward; -1: on its way in; 0: passes it.
  int crossing(const glm::dvec3& p) const {
    const int left = isLeft(0, 1, p) + isLeft(1, 2, p) + isLeft(2, 0, p);
    // leaning coordinates are left-handed
    return left == 3 ? -1 : left == 0 ? 1 : 0;
  }
  double heightAt(const glm::dvec3& p) const {
    if (normal_.z == 0.0) return low.z;
    const glm::dvec3 from = p - at_[0];
    return std::clamp(at_[0].z - (normal_.x * from.x + normal_.y * from.y) / normal_.z, low.z, high.z);
  }

  glm::dvec3 low, high;

 private:
  bool isLeft(int from, int to, const glm::dvec3& p) const {
    if (id_[from] > id_[to]) return !isLeft(to, from, p);
    const glm::dvec3 &a = at_[from], &b = at_[to];
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0.0;
  }

  std::array<uint32_t, 3> id_;
  std::array<glm::dvec3, 3> at_;
  glm::dvec3 normal_;
};

// Finds what lies in which shell.
class Nesting {
 public:
  Nesting(const Scene& scene, const Parts& parts) : scene_(scene), parts_(parts), grid_(gatherPoints()) {}

  const std::vector<Thing>& things() const { return things_; }

  // By part: whether something is within it, and not in what it encloses.
  const std::vector<char>& hasRooms() const { return has_rooms_; }

  // False when that would take too long.
  bool find() {
    of_point_.assign(grid_.points().size(), {});
    of_thing_.assign(things_.size(), {});
    has_rooms_.assign(parts_.all.size(), 0);
    std::vector<uint32_t> shells;
    for (uint32_t i = 0; i < parts_.all.size(); ++i) {
      if (parts_.all[i].isShell()) shells.push_back(i);
    }
    // the smallest one comes last, and stays
    std::stable_sort(shells.begin(), shells.end(), [&](uint32_t a, uint32_t b) {
      return std::abs(parts_.all[a].shell.volume_m3) > std::abs(parts_.all[b].shell.volume_m3);
    });
    for (const uint32_t part : shells) {
      if (!meet(part)) return false;
      takeStock(part);
    }
    return true;
  }

 private:
  std::vector<Point> gatherPoints() {
    std::vector<Point> points;
    const auto addPlace = [&](const glm::vec3& position) {
      points.push_back({leaning(position), static_cast<uint32_t>(things_.size())});
      things_.push_back({kAbsent, 1});
    };
    for (const Lamp& lamp : scene_.light.lamps) addPlace(lamp.position);
    for (const Viewpoint& viewpoint : scene_.viewpoints) addPlace(viewpoint.position);
    std::vector<uint32_t> largest(parts_.all.size());
    std::iota(largest.begin(), largest.end(), 0u);
    if (largest.size() > kMostParts) {
      std::nth_element(largest.begin(), largest.begin() + kMostParts, largest.end(), [&](uint32_t a, uint32_t b) {
        const double area_a = parts_.all[a].shell.area_m2, area_b = parts_.all[b].shell.area_m2;
        return area_a != area_b ? area_a > area_b : a < b;
      });
      largest.resize(kMostParts);
    }
    for (const uint32_t part : largest) {
      const size_t before = points.size();
      addPoints(scene_, parts_, parts_.all[part], static_cast<uint32_t>(things_.size()), &points);
      things_.push_back({part, static_cast<uint32_t>(points.size() - before)});
    }
    return points;
  }

  // Winds one shell around all points.
  bool meet(uint32_t part_idx) {
    const Part& part = parts_.all[part_idx];
    for (uint32_t i = 0; i < part.count; ++i) {
      const Face face(scene_, parts_, scene_.triangles[parts_.triangles[part.first + i]]);
      grid_.visitRows(face.low, face.high, [&](uint32_t first, uint32_t end) {
        test_count_ += end - first + 1;
        for (uint32_t p = first; p < end; ++p) meet(face, part_idx, p);
      });
      if (test_count_ > kMostTests) return false;
    }
    return true;
  }

  void meet(const Face& face, uint32_t part_idx, uint32_t point_idx) {
    const Point& point = grid_.points()[point_idx];
    if (things_[point.thing].part == part_idx) return;
    const int crossing = face.crossing(point.at);
    if (crossing == 0) return;
    Winding& winding = of_point_[point_idx];
    if (!winding.is_met) met_.push_back(point_idx);
    winding.is_met = true;
    const double above = face.heightAt(point.at) - point.at.z;
    if (std::abs(above) < kTouch_m) winding.is_touching = true;
    (above > 0.0 ? winding.is_below : winding.is_above) = true;
    (above > 0.0 ? winding.upward : winding.downward) += above > 0.0 ? crossing : -crossing;
  }

  void takeStock(uint32_t part_idx) {
    const int sign = parts_.all[part_idx].isOutward() ? 1 : -1;
    std::vector<uint32_t> met_things;
    for (const uint32_t p : met_) {
      const uint32_t thing = grid_.points()[p].thing;
      const Winding winding = std::exchange(of_point_[p], {});
      // one of them may have gone through a hole
      const bool is_inside = sign * winding.upward > 0 || sign * winding.downward > 0;
      const bool is_between = winding.is_below && winding.is_above;
      if (!winding.is_touching && !is_inside && !is_between) continue;
      Tally& tally = of_thing_[thing];
      if (tally.inside + tally.touching + tally.between == 0) met_things.push_back(thing);
      ++(winding.is_touching ? tally.touching : is_inside ? tally.inside : tally.between);
    }
    met_.clear();
    for (const uint32_t t : met_things) {
      Thing& thing = things_[t];
      const Tally tally = std::exchange(of_thing_[t], {});
      const double most = kMostInside * (thing.point_count - tally.touching);
      if (tally.inside + tally.touching > 0) thing.is_outside = false;
      if (tally.inside > 0 && tally.inside >= most) thing.container = part_idx;
      if (tally.between > 0 && tally.between >= most) has_rooms_[part_idx] = 1;
    }
  }

  // Of the shell at hand: around a point, by the faces above it and by those below.
  struct Winding {
    int32_t upward = 0, downward = 0;
    bool is_met = false, is_below = false, is_above = false, is_touching = false;
  };
  // A thing's points.
  struct Tally {
    uint32_t inside = 0, touching = 0, between = 0;
  };

  const Scene& scene_;
  const Parts& parts_;
  std::vector<Thing> things_;
  PointGrid grid_;
  std::vector<Winding> of_point_;
  std::vector<uint32_t> met_;  // points
  std::vector<Tally> of_thing_;
  std::vector<char> has_rooms_;
  uint64_t test_count_ = 0;
};

// Whether a ball of the scene's cavity_m fits into shells: else what stands in one is sunk into a wall, or is a cupboard's shelf.
class Width {
 public:
  // container   by part
  Width(const Scene& scene, const Parts& parts, const std::vector<uint32_t>& container) : scene_(scene), parts_(parts) {
    for (uint32_t i = 0; i < container.size(); ++i) {
      if (container[i] != kAbsent && parts.all[i].isInward()) inner_[container[i]].push_back(i);
    }
  }

  bool isWide(uint32_t part_idx) {
    if (!(scene_.cavity_m > 0.0)) return true;
    std::vector<Facet> facets;
    addFacets(part_idx, &facets);
    // between the two surfaces of thick walls
    for (const uint32_t inner : inner_[part_idx]) addFacets(inner, &facets);
    return ballFits(facets, scene_.cavity_m, &tests_left_).value_or(true);
  }

 private:
  void addFacets(uint32_t part_idx, std::vector<Facet>* facets) const {
    const Part& part = parts_.all[part_idx];
    for (uint32_t i = part.first; i < part.first + part.count; ++i) {
      const glm::uvec3& t = scene_.triangles[parts_.triangles[i]];
      facets->push_back({scene_.positions[t.x], scene_.positions[t.y], scene_.positions[t.z]});
    }
  }

  const Scene& scene_;
  const Parts& parts_;
  std::map<uint32_t, std::vector<uint32_t>> inner_;  // by part, those wound inward in it
  uint64_t tests_left_ = kMostBallTests;
};

// By part: whether its faces bound solid.
struct Verdict {
  std::vector<char> is_hollow, is_solid;
  std::vector<char> is_room;  // wound outward, and seen from within alone: its faces look inward once they are turned
};

Verdict judge(const Scene& scene, const Parts& parts, const Nesting& nesting) {
  const std::vector<Thing>& things = nesting.things();
  const size_t count = parts.all.size();
  Verdict verdict{std::vector<char>(count, 0), std::vector<char>(count, 0), std::vector<char>(count, 0)};
  // what each shell holds, and what lies in none
  std::vector<char> is_part_outside(count, 0);
  size_t outside_count = 0;
  std::vector<char> holds_something(count, 0);
  std::vector<uint32_t> container(count, kAbsent);
  const auto isInward = [&](const Thing& thing) { return thing.part != kAbsent && parts.all[thing.part].isInward(); };
  for (const Thing& thing : things) {
    if (thing.part != kAbsent) container[thing.part] = thing.container;
    if (thing.part != kAbsent) is_part_outside[thing.part] = thing.is_outside;
    outside_count += thing.is_outside;
    if (thing.container == kAbsent) continue;
    holds_something[thing.container] = 1;
    // an inner surface leaves walls between itself and the outer one
    if (parts.all[thing.container].isOutward() && !isInward(thing)) verdict.is_hollow[thing.container] = 1;
  }
  // a room around everything leaves no air outside
  const bool is_air_outside = std::any_of(things.begin(), things.end(), [&](const Thing& thing) {
    return thing.is_outside && !(isInward(thing) && holds_something[thing.part]);
  });
  // a lone empty shell that fills the scene is a room: taken as solid it would leave no air
  const Bounds bounds = sceneBounds(scene);
  const auto boxVolume = [](const glm::dvec3& size) { return size.x * size.y * size.z; };
  const double scene_volume = boxVolume(bounds.max - bounds.min);
  const auto isAllThereIs = [&](const Shell& shell) {
    return shell.volume_m3 > kMostOfScene * scene_volume && boxVolume(shell.high - shell.low) > kWholeScene * scene_volume;
  };
  // shells wound outward (docs/theory/visibility.md, Double-sided materials, first rows of the table)
  Width width(scene, parts, container);
  for (uint32_t i = 0; i < count; ++i) {
    if (!parts.all[i].isOutward()) continue;
    // others are solid in any case
    const bool is_narrow = (verdict.is_hollow[i] || parts.all[i].hasHoles()) && !width.isWide(i);
    if (is_narrow) verdict.is_hollow[i] = 0;
    const bool is_alone = outside_count == static_cast<size_t>(is_part_outside[i]);
    if (!holds_something[i] && is_alone && isAllThereIs(parts.all[i].shell)) verdict.is_hollow[i] = 1;
    verdict.is_room[i] = verdict.is_hollow[i] && is_alone;
    verdict.is_solid[i] = !verdict.is_hollow[i] && (!parts.all[i].hasHoles() || nesting.hasRooms()[i] || is_narrow);
  }
  // shells wound inward: the inner surface of thick walls, or a room around everything else
  for (uint32_t i = 0; i < count; ++i) {
    if (!parts.all[i].isInward()) continue;
    const bool is_loose = container[i] == kAbsent;
    const bool is_cavity = !is_loose && verdict.is_solid[container[i]] && parts.all[container[i]].isOutward();
    verdict.is_solid[i] = is_cavity || (is_loose && holds_something[i] && !is_air_outside);
  }
  return verdict;
}

}  // namespace

std::string DoubleSidedFaces::note() const {
  if (face_count == 0 || (solid_count == face_count && hollow.empty() && turned.empty())) return {};
  if (is_too_tangled)
    return "its double-sided faces are no evidence of solid: more closed parts lie over each other than are looked into";
  std::string text = solid_count == face_count ? fmt::format("all of its {} double-sided faces bound solid", face_count)
                                               : fmt::format("{} of its {} double-sided faces bound solid, {} are sheets",
                                                             solid_count, face_count, face_count - solid_count);
  const auto addNames = [&](const char* words, const std::vector<std::string>& objects) {
    if (objects.empty()) return;
    const size_t named = std::min(objects.size(), kNamedObjects);
    text += fmt::format("; {}: {}", words, fmt::join(objects.begin(), objects.begin() + named, ", "));
    if (named < objects.size()) text += fmt::format(" and {} more", objects.size() - named);
  };
  addNames("hollow, since it is wide and something lies in it, and walls with a thickness leak less than its sheets", hollow);
  addNames("a room seen from within, so that its faces were turned inward", turned);
  return text;
}

DoubleSidedFaces giveSolidsOneSide(Scene& scene) {
  DoubleSidedFaces result;
  for (const uint32_t material : scene.triangle_material) result.face_count += isDoubleSided(scene.materials[material]);
  if (result.face_count == 0) return result;
  // without an answer who is in whom, all faces stay sheets
  const Parts parts = partsOf(scene);
  Nesting nesting(scene, parts);
  if (!nesting.find()) {
    result.is_too_tangled = true;
    return result;
  }
  const Verdict verdict = judge(scene, parts, nesting);
  // a material may bound solid on one part and be a sheet on another: solids get a one-sided copy
  std::map<uint32_t, uint32_t> one_sided;  // by material
  for (size_t i = 0; i < parts.all.size(); ++i) {
    const Part& part = parts.all[i];
    uint32_t face_count = 0;
    for (uint32_t k = part.first; k < part.first + part.count; ++k) {
      uint32_t& material = scene.triangle_material[parts.triangles[k]];
      if (!isDoubleSided(scene.materials[material])) continue;
      ++face_count;
      // two corners swapped: the face turns inward
      if (verdict.is_room[i]) std::swap(scene.triangles[parts.triangles[k]].y, scene.triangles[parts.triangles[k]].z);
      if (!verdict.is_solid[i] && !verdict.is_room[i]) continue;
      const auto [copy, is_new] = one_sided.try_emplace(material, static_cast<uint32_t>(scene.materials.size()));
      if (is_new) {
        scene.materials.push_back(scene.materials[material]);
        scene.materials.back().double_sided = false;
      }
      material = copy->second;
    }
    if (verdict.is_solid[i] || verdict.is_room[i]) result.solid_count += face_count;
    // names for the user, one for each object and not for each of its parts
    const std::string& name = scene.objects[part.object].name;
    std::vector<std::string>& told = verdict.is_room[i] ? result.turned : result.hollow;
    if (verdict.is_hollow[i] && face_count > 0 && (told.empty() || told.back() != name)) told.push_back(name);
  }
  return result;
}

}  // namespace nlg
