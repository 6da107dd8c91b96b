#include "datagen/scene/scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "tool/atomic_file.h"

namespace nlg {
namespace {

void grow(Bounds& bounds, const glm::vec3& p, bool is_first) {
  bounds.min = is_first ? p : glm::min(bounds.min, p);
  bounds.max = is_first ? p : glm::max(bounds.max, p);
}

float largestSide(const Bounds& bounds) {
  const glm::vec3 size = bounds.max - bounds.min;
  return std::max({size.x, size.y, size.z});
}

uint32_t findRoot(std::vector<uint32_t>& parent, uint32_t vertex) {
  while (parent[vertex] != vertex) vertex = parent[vertex] = parent[parent[vertex]];
  return vertex;
}

// For every vertex the first one with the same position, bit for bit.
std::vector<uint32_t> weldedVertices(const std::vector<glm::vec3>& positions) {
  const auto bits = [&](uint32_t vertex) {
    const glm::vec3& p = positions[vertex];
    return std::array{std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z)};
  };
  std::vector<uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return bits(a) < bits(b); });
  std::vector<uint32_t> welded(positions.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && bits(order[i]) == bits(order[i - 1]);
    welded[order[i]] = is_same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

bool isFlat(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return normal.x == 0.0 && normal.y == 0.0 && normal.z == 0.0;
}

void dropFlatTriangles(Scene& scene) {
  std::vector<SceneObject> objects;
  uint32_t kept = 0;
  for (SceneObject object : scene.objects) {
    const uint32_t end = object.first_triangle + object.triangle_count;
    const uint32_t first_kept = kept;
    for (uint32_t i = object.first_triangle; i < end; ++i) {
      const glm::uvec3 t = scene.triangles[i];
      if (isFlat(scene.positions[t.x], scene.positions[t.y], scene.positions[t.z])) continue;
      scene.triangles[kept] = t;
      scene.triangle_material[kept++] = scene.triangle_material[i];
    }
    object.first_triangle = first_kept;
    object.triangle_count = kept - first_kept;
    if (object.triangle_count > 0) objects.push_back(object);
  }
  scene.dropped_triangle_count = static_cast<uint32_t>(scene.triangles.size()) - kept;
  scene.triangles.resize(kept);
  scene.triangle_material.resize(kept);
  scene.objects = std::move(objects);
}

// Sorts triangles of one object by component, components by their first triangle, and appends an object for each.
class ComponentSplitter {
 public:
  explicit ComponentSplitter(Scene& scene)
      : scene_(scene), welded_(weldedVertices(scene.positions)), parent_(welded_), first_seen_(welded_.size(), kNone) {
    triangles_.reserve(scene.triangles.size());
    materials_.reserve(scene.triangles.size());
  }

  void keep(const SceneObject& object) {
    objects_.push_back(object);
    for (uint32_t i = 0; i < object.triangle_count; ++i) append(object.first_triangle + i);
  }

  void split(const SceneObject& object) {
    const uint32_t end = object.first_triangle + object.triangle_count;
    for (uint32_t t = object.first_triangle; t < end; ++t) join(scene_.triangles[t]);

    // counting sort by component
    std::vector<uint32_t> component(object.triangle_count);
    std::vector<uint32_t> counts;
    for (uint32_t t = object.first_triangle; t < end; ++t) {
      const uint32_t root = findRoot(parent_, welded_[scene_.triangles[t].x]);
      if (first_seen_[root] == kNone) {
        first_seen_[root] = static_cast<uint32_t>(counts.size());
        counts.push_back(0);
      }
      ++counts[component[t - object.first_triangle] = first_seen_[root]];
    }
    std::vector<uint32_t> offsets(counts.size(), 0);
    for (size_t c = 1; c < counts.size(); ++c) offsets[c] = offsets[c - 1] + counts[c - 1];
    for (size_t c = 0; c < counts.size(); ++c) {
      const std::string name = counts.size() == 1 ? object.name : object.name + "/" + std::to_string(c);
      objects_.push_back({name, static_cast<uint32_t>(triangles_.size()) + offsets[c], counts[c], true});
    }
    std::vector<uint32_t> order(object.triangle_count);
    for (uint32_t i = 0; i < object.triangle_count; ++i) order[offsets[component[i]]++] = object.first_triangle + i;
    for (const uint32_t t : order) append(t);
    for (uint32_t t = object.first_triangle; t < end; ++t) release(scene_.triangles[t]);
  }

  void finish() {
    scene_.triangles = std::move(triangles_);
    scene_.triangle_material = std::move(materials_);
    scene_.objects = std::move(objects_);
  }

 private:
  static constexpr uint32_t kNone = ~0u;

  void append(uint32_t triangle) {
    triangles_.push_back(scene_.triangles[triangle]);
    materials_.push_back(scene_.triangle_material[triangle]);
  }

  void join(const glm::uvec3& triangle) {
    for (int corner = 1; corner < 3; ++corner) {
      const uint32_t a = findRoot(parent_, welded_[triangle[0]]);
      const uint32_t b = findRoot(parent_, welded_[triangle[corner]]);
      parent_[std::max(a, b)] = std::min(a, b);
    }
  }

  // objects that only touch each other stay apart: the next object starts with every vertex by itself
  void release(const glm::uvec3& triangle) {
    for (int corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = welded_[triangle[corner]];
      parent_[vertex] = vertex;
      first_seen_[vertex] = kNone;
    }
  }

  Scene& scene_;
  std::vector<uint32_t> welded_, parent_, first_seen_;
  std::vector<glm::uvec3> triangles_;
  std::vector<uint32_t> materials_;
  std::vector<SceneObject> objects_;
};

}  // namespace

Bounds objectBounds(const Scene& scene, const SceneObject& object) {
  Bounds bounds;
  for (uint32_t i = 0; i < object.triangle_count; ++i) {
    const glm::uvec3& triangle = scene.triangles[object.first_triangle + i];
    for (int corner = 0; corner < 3; ++corner) grow(bounds, scene.positions[triangle[corner]], i == 0 && corner == 0);
  }
  return bounds;
}

Bounds sceneBounds(const Scene& scene) {
  Bounds bounds;
  for (size_t i = 0; i < scene.positions.size(); ++i) grow(bounds, scene.positions[i], i == 0);
  return bounds;
}

void finishScene(Scene& scene, const std::vector<glm::dvec3>& world_positions_m) {
  if (!world_positions_m.empty()) {
    glm::dvec3 low = world_positions_m[0];
    glm::dvec3 high = low;
    for (const glm::dvec3& p : world_positions_m) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    scene.origin_m = glm::round(0.5 * (low + high));
  }
  scene.positions.reserve(world_positions_m.size());
  for (const glm::dvec3& p : world_positions_m) scene.positions.emplace_back(p - scene.origin_m);
  dropFlatTriangles(scene);
}

std::string sceneSha256(const Scene& scene) {
  std::string bytes;
  const auto append = [&](const void* values, size_t size) { bytes.append(static_cast<const char*>(values), size); };
  append(&scene.origin_m, sizeof(scene.origin_m));
  append(scene.positions.data(), scene.positions.size() * sizeof(glm::vec3));
  append(scene.triangles.data(), scene.triangles.size() * sizeof(glm::uvec3));
  for (const uint32_t material : scene.triangle_material) bytes.push_back(scene.materials[material].double_sided ? 1 : 0);
  for (const SceneObject& object : scene.objects) {
    append(&object.first_triangle, sizeof(object.first_triangle));
    append(&object.triangle_count, sizeof(object.triangle_count));
    bytes.push_back(object.movable ? 1 : 0);
  }
  return sha256(bytes);
}

void splitConnectedComponents(Scene& scene, double structure_share) {
  const double limit = structure_share * largestSide(sceneBounds(scene));
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

}  // namespace nlg
