// A component is closed if its edges cancel: every edge is walked once in each direction. What remains open goes around
// holes, whose area tells a crack of a modeller from a surface that bounds nothing.
#include "scene/solid/closed_shells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <numeric>
#include <tuple>
#include <utility>

namespace nlg {
namespace {

constexpr uint32_t kNone = ~0u;

struct Edge {
  uint32_t low, high;  // vertices
  uint32_t component;
  int32_t direction;  // 1: from low to high; -1: the other way. Of several: their sum

  bool isAlong(const Edge& other) const { return low == other.low && high == other.high; }
};

// One after another along the same two vertices.
std::vector<Edge> sortedEdges(std::span<const glm::uvec3> triangles, const std::vector<uint32_t>& of_triangle,
                              const std::vector<uint32_t>& same_as) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = same_as[triangles[i][k]], to = same_as[triangles[i][(k + 1) % 3]];
      edges.push_back({std::min(from, to), std::max(from, to), of_triangle[i], from < to ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return std::tie(a.low, a.high) < std::tie(b.low, b.high); });
  return edges;
}

// Volume that the faces enclose towards the box's centre, as a share of the box: 1 for a whole box that looks outward, 5/6
// without one side, 0 for a sheet, negative for a room.
constexpr double kOutwardShare = 0.5;
constexpr double kOpenShare = 0.05;  // of the edges' length: below, a component counts as closed

constexpr double kLargestSide_m = 12.0;  // a level that was compiled with a leak holds rooms with thick walls, closed all round

bool isFreeStanding(const Shell& shell) {
  const glm::dvec3 size = shell.high - shell.low;
  if (std::max({size.x, size.y, size.z}) > kLargestSide_m) return false;
  const bool is_closed = shell.open_length_m <= kOpenShare * shell.edge_length_m;
  return shell.volume_m3 > 0.0 && (shell.volume_m3 > kOutwardShare * size.x * size.y * size.z || is_closed);
}

float largestSide(const Bounds& bounds) {
  const glm::vec3 size = bounds.max - bounds.min;
  return std::max({size.x, size.y, size.z});
}

// Sorts triangles of one object by component, components by their first triangle, and appends an object for each.
class ComponentSplitter {
 public:
  explicit ComponentSplitter(Scene& scene) : scene_(scene), finder_(weldedVertices(scene.positions)) {
    triangles_.reserve(scene.triangles.size());
    materials_.reserve(scene.triangles.size());
  }

  void keep(const SceneObject& object) {
    objects_.push_back(object);
    for (uint32_t i = 0; i < object.triangle_count; ++i) append(object.first_triangle + i);
  }

  void split(const SceneObject& object) {
    // counting sort by component
    const auto [component, count] = finder_.components({scene_.triangles.data() + object.first_triangle, object.triangle_count});
    std::vector<uint32_t> counts(count, 0);
    for (const uint32_t c : component) ++counts[c];
    std::vector<uint32_t> offsets(counts.size(), 0);
    for (size_t c = 1; c < counts.size(); ++c) offsets[c] = offsets[c - 1] + counts[c - 1];
    for (size_t c = 0; c < counts.size(); ++c) {
      const std::string name = counts.size() == 1 ? object.name : object.name + "/" + std::to_string(c);
      objects_.push_back({name, static_cast<uint32_t>(triangles_.size()) + offsets[c], counts[c], true});
    }
    std::vector<uint32_t> order(object.triangle_count);
    for (uint32_t i = 0; i < object.triangle_count; ++i) order[offsets[component[i]]++] = object.first_triangle + i;
    for (const uint32_t t : order) append(t);
  }

  void finish() {
    scene_.triangles = std::move(triangles_);
    scene_.triangle_material = std::move(materials_);
    scene_.light.baked.triangle_page = std::move(pages_);
    scene_.objects = std::move(objects_);
  }

 private:
  void append(uint32_t triangle) {
    triangles_.push_back(scene_.triangles[triangle]);
    materials_.push_back(scene_.triangle_material[triangle]);
    const std::vector<int32_t>& pages = scene_.light.baked.triangle_page;
    if (!pages.empty()) pages_.push_back(pages[triangle]);
  }

  Scene& scene_;
  ShellFinder finder_;
  std::vector<glm::uvec3> triangles_;
  std::vector<uint32_t> materials_;
  std::vector<int32_t> pages_;  // of baked light
  std::vector<SceneObject> objects_;
};

}  // namespace

std::vector<uint32_t> weldedVertices(const std::vector<glm::vec3>& positions) {
  using Bits = std::array<uint32_t, 3>;
  std::vector<std::pair<Bits, uint32_t>> order;
  order.reserve(positions.size());
  for (const glm::vec3& p : positions) {
    const Bits bits{std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z)};
    order.emplace_back(bits, static_cast<uint32_t>(order.size()));
  }
  std::sort(order.begin(), order.end());
  std::vector<uint32_t> welded(positions.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && order[i].first == order[i - 1].first;
    welded[order[i].second] = is_same ? welded[order[i - 1].second] : order[i].second;
  }
  return welded;
}

ShellFinder::ShellFinder(std::vector<uint32_t> same_as)
    : same_as_(std::move(same_as)), parent_(same_as_.size()), number_(same_as_.size(), kNone) {
  std::iota(parent_.begin(), parent_.end(), 0u);
}

uint32_t ShellFinder::rootOf(uint32_t vertex) {
  while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
  return vertex;
}

void ShellFinder::join(uint32_t a, uint32_t b) {
  a = rootOf(a);
  b = rootOf(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

uint32_t ShellFinder::numberOf(uint32_t vertex, uint32_t* count) {
  uint32_t& number = number_[rootOf(vertex)];
  if (number == kNone) number = (*count)++;
  return number;
}

void ShellFinder::release(uint32_t vertex) {
  parent_[vertex] = vertex;
  number_[vertex] = kNone;
}

Components ShellFinder::components(std::span<const glm::uvec3> triangles) {
  for (const glm::uvec3& t : triangles) {
    for (const uint32_t other : {t.y, t.z}) join(same_as_[t.x], same_as_[other]);
  }
  Components found;
  found.of_triangle.reserve(triangles.size());
  for (const glm::uvec3& t : triangles) found.of_triangle.push_back(numberOf(same_as_[t.x], &found.count));
  for (const glm::uvec3& t : triangles) {
    for (int k = 0; k < 3; ++k) release(same_as_[t[k]]);
  }
  return found;
}

template <class Position>
std::vector<Shell> ShellFinder::measure(const std::vector<Position>& positions, std::span<const glm::uvec3> triangles,
                                        const Components& components) {
  // volume is summed about the middle of the box: that of an open component depends on the origin
  std::vector<Shell> shells(components.count);
  std::vector<char> is_begun(components.count, 0);
  for (size_t i = 0; i < triangles.size(); ++i) {
    Shell& shell = shells[components.of_triangle[i]];
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p(positions[triangles[i][k]]);
      const bool is_first = !std::exchange(is_begun[components.of_triangle[i]], 1);
      shell.low = is_first ? p : glm::min(shell.low, p);
      shell.high = is_first ? p : glm::max(shell.high, p);
    }
  }
  const auto fromMiddle = [&](const Shell& shell, uint32_t vertex) {
    return glm::dvec3(positions[vertex]) - 0.5 * (shell.low + shell.high);
  };
  // signed volume of the tetrahedra between middle and faces: positive if wound outward
  for (size_t i = 0; i < triangles.size(); ++i) {
    Shell& shell = shells[components.of_triangle[i]];
    const glm::dvec3 a = fromMiddle(shell, triangles[i].x), b = fromMiddle(shell, triangles[i].y);
    const glm::dvec3 c = fromMiddle(shell, triangles[i].z);
    shell.volume_m3 += glm::dot(a, glm::cross(b, c)) / 6.0;
    shell.area_m2 += 0.5 * glm::length(glm::cross(b - a, c - a));
  }

  // edges of two triangles that meet along them cancel
  const std::vector<Edge> edges = sortedEdges(triangles, components.of_triangle, same_as_);
  std::vector<Edge> open;
  for (size_t i = 0; i < edges.size();) {
    Edge sum = edges[i];
    Shell& shell = shells[sum.component];
    const double length = glm::length(fromMiddle(shell, sum.high) - fromMiddle(shell, sum.low));
    for (shell.edge_length_m += length; ++i < edges.size() && edges[i].isAlong(sum); shell.edge_length_m += length)
      sum.direction += edges[i].direction;
    if (sum.direction == 0) continue;
    shell.open_length_m += std::abs(sum.direction) * length;
    open.push_back(sum);
  }

  // a hole is what connected open edges go round
  for (const Edge& edge : open) join(edge.low, edge.high);
  std::vector<glm::dvec3> holes;
  std::vector<uint32_t> component_of_hole;
  uint32_t count = 0;
  for (const Edge& edge : open) {
    const uint32_t hole = numberOf(edge.low, &count);
    if (hole == holes.size()) {
      holes.emplace_back(0.0);
      component_of_hole.push_back(edge.component);
    }
    // area vector of the hole's outline: half the sum of cross products of its edges
    const Shell& shell = shells[edge.component];
    holes[hole] += 0.5 * edge.direction * glm::cross(fromMiddle(shell, edge.low), fromMiddle(shell, edge.high));
  }
  for (size_t i = 0; i < holes.size(); ++i) shells[component_of_hole[i]].hole_area_m2 += glm::length(holes[i]);
  for (const Edge& edge : open) {
    release(edge.low);
    release(edge.high);
  }
  return shells;
}

template std::vector<Shell> ShellFinder::measure(const std::vector<glm::vec3>&, std::span<const glm::uvec3>, const Components&);
template std::vector<Shell> ShellFinder::measure(const std::vector<glm::dvec3>&, std::span<const glm::uvec3>, const Components&);

void splitConnectedComponents(Scene& scene, double structure_share) {
  const double limit = structure_share * largestSide(geometryBounds(scene));
  ComponentSplitter splitter(scene);
  for (const SceneObject& object : scene.objects) {
    if (object.movable) {
      splitter.split(object);
    } else {
      splitter.keep(object);
    }
  }
  splitter.finish();
  for (SceneObject& object : scene.objects) object.movable = object.movable && largestSide(objectBounds(scene, object)) <= limit;
}

void splitFreeStanding(Scene& scene, size_t object_idx) {
  // only this one is split: what is not movable stays whole
  std::vector<bool> was_movable;
  for (SceneObject& object : scene.objects) was_movable.push_back(std::exchange(object.movable, false));
  const size_t behind = scene.objects.size() - object_idx - 1;
  scene.objects[object_idx].movable = true;
  splitConnectedComponents(scene, 1.0);
  ShellFinder finder(weldedVertices(scene.positions));
  for (size_t i = object_idx; i + behind < scene.objects.size(); ++i) {
    SceneObject& object = scene.objects[i];
    const std::span triangles(scene.triangles.data() + object.first_triangle, object.triangle_count);
    object.movable = isFreeStanding(finder.measure(scene.positions, triangles, finder.components(triangles))[0]);
  }
  for (size_t i = 0; i < object_idx; ++i) scene.objects[i].movable = was_movable[i];
  for (size_t i = 0; i < behind; ++i) scene.objects[scene.objects.size() - behind + i].movable = was_movable[object_idx + 1 + i];
}

}  // namespace nlg
