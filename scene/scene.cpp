#include "scene/scene.h"

#include <algorithm>
#include <type_traits>

#include <fmt/format.h>

#include "scene/closed_shells.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

void grow(Bounds& bounds, const glm::vec3& p, bool is_first) {
  bounds.min = is_first ? p : glm::min(bounds.min, p);
  bounds.max = is_first ? p : glm::max(bounds.max, p);
}

Bounds geometryBounds(const Scene& scene) {
  Bounds bounds;
  for (size_t i = 0; i < scene.positions.size(); ++i) grow(bounds, scene.positions[i], i == 0);
  return bounds;
}

float largestSide(const Bounds& bounds) {
  const glm::vec3 size = bounds.max - bounds.min;
  return std::max({size.x, size.y, size.z});
}

bool isFlat(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return normal.x == 0.0 && normal.y == 0.0 && normal.z == 0.0;
}

void dropFlatTriangles(Scene& scene) {
  std::vector<SceneObject> objects;
  std::vector<int32_t>& pages = scene.light.baked.triangle_page;
  uint32_t kept = 0;
  for (SceneObject object : scene.objects) {
    const uint32_t end = object.first_triangle + object.triangle_count;
    const uint32_t first_kept = kept;
    for (uint32_t i = object.first_triangle; i < end; ++i) {
      const glm::uvec3 t = scene.triangles[i];
      if (isFlat(scene.positions[t.x], scene.positions[t.y], scene.positions[t.z])) continue;
      scene.triangles[kept] = t;
      if (!pages.empty()) pages[kept] = pages[i];
      scene.triangle_material[kept++] = scene.triangle_material[i];
    }
    object.first_triangle = first_kept;
    object.triangle_count = kept - first_kept;
    if (object.triangle_count > 0) objects.push_back(object);
  }
  scene.dropped_triangle_count = static_cast<uint32_t>(scene.triangles.size()) - kept;
  scene.triangles.resize(kept);
  scene.triangle_material.resize(kept);
  if (!pages.empty()) pages.resize(kept);
  scene.objects = std::move(objects);
}

class HashedBytes {
 public:
  template <class Value>
  void add(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(Value));
  }
  template <class Value>
  void addAll(const std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
  }
  template <class Value>
  void addCounted(const std::vector<Value>& values) {
    add<uint64_t>(values.size());
    addAll(values);
  }
  void addText(const std::string& text) { bytes_ += text; }
  std::string hash() const { return sha256(bytes_); }

 private:
  std::string bytes_;
};

// Images, vertices' colours and veils: nothing for a scene that has none.
void addLooks(const Scene& scene, HashedBytes& bytes) {
  const bool has_veils = std::any_of(scene.materials.begin(), scene.materials.end(),
                                     [](const Material& material) { return material.veil != Veil::none; });
  if (scene.images.empty() && scene.vertex_colours.empty() && !has_veils) return;
  for (const TextureImage& image : scene.images) {
    bytes.add(image.width);
    bytes.addCounted(image.texels);
  }
  for (const Material& material : scene.materials) {
    bytes.add(material.opacity);
    bytes.add(material.transmission);
    for (const TextureUse* use : {&material.base_image, &material.emissive_image, &material.transmission_image}) {
      bytes.add(use->image);
      bytes.add(use->wrap_u);
      bytes.add(use->wrap_v);
    }
  }
  bytes.addCounted(scene.triangle_material);
  bytes.addCounted(scene.base_places);
  bytes.addCounted(scene.emissive_places);
  bytes.addCounted(scene.vertex_colours);
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

Bounds objectBounds(const Scene& scene, const SceneObject& object) {
  Bounds bounds;
  for (uint32_t i = 0; i < object.triangle_count; ++i) {
    const glm::uvec3& triangle = scene.triangles[object.first_triangle + i];
    for (int corner = 0; corner < 3; ++corner) grow(bounds, scene.positions[triangle[corner]], i == 0 && corner == 0);
  }
  return bounds;
}

Bounds sceneBounds(const Scene& scene) {
  Bounds bounds = geometryBounds(scene);
  const std::vector<glm::vec3>& sky = scene.light.sky_faces.positions;
  for (size_t i = 0; i < sky.size(); ++i) grow(bounds, sky[i], i == 0 && scene.positions.empty());
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
  scene.positions = relativeTo(scene.origin_m, world_positions_m);
  dropFlatTriangles(scene);
}

std::vector<glm::vec3> relativeTo(const glm::dvec3& origin_m, const std::vector<glm::dvec3>& world_positions_m) {
  std::vector<glm::vec3> positions;
  positions.reserve(world_positions_m.size());
  for (const glm::dvec3& p : world_positions_m) positions.emplace_back(p - origin_m);
  return positions;
}

std::string sceneSha256(const Scene& scene) {
  HashedBytes bytes;
  bytes.add(scene.origin_m);
  bytes.addAll(scene.positions);
  bytes.addAll(scene.triangles);
  for (const uint32_t material : scene.triangle_material) {
    const Material& m = scene.materials[material];
    bytes.add<char>(static_cast<char>((m.double_sided ? 1 : 0) + 2 * static_cast<int>(m.veil)));
  }
  for (const SceneObject& object : scene.objects) {
    bytes.add(object.first_triangle);
    bytes.add(object.triangle_count);
    bytes.add<char>(object.movable ? 1 : 0);
  }
  if (scene.extent) {
    bytes.add(scene.extent->low_m);
    bytes.add(scene.extent->high_m);
  }
  return bytes.hash();
}

std::string geometryDifference(const Scene& scene, const Scene& other) {
  const auto counted = [](size_t count, const char* what, size_t not_count) {
    return fmt::format("{} {}, not {}", count, what, not_count);
  };
  if (other.triangles.size() != scene.triangles.size())
    return counted(other.triangles.size(), "triangles", scene.triangles.size());
  if (other.objects.size() != scene.objects.size()) return counted(other.objects.size(), "objects", scene.objects.size());
  const auto cornerAt = [](const Scene& of, size_t triangle, int corner) {
    return of.origin_m + glm::dvec3(of.positions[of.triangles[triangle][corner]]);
  };
  for (size_t o = 0; o < scene.objects.size(); ++o) {
    const SceneObject &a = scene.objects[o], &b = other.objects[o];
    if (a.first_triangle != b.first_triangle || a.triangle_count != b.triangle_count)
      return fmt::format("{} triangles of '{}', not {} of '{}'", b.triangle_count, b.name, a.triangle_count, a.name);
    for (size_t t = a.first_triangle; t < size_t{a.first_triangle} + a.triangle_count; ++t) {
      for (int corner = 0; corner < 3; ++corner) {
        const glm::dvec3 here = cornerAt(scene, t, corner), there = cornerAt(other, t, corner);
        if (here != there)
          return fmt::format("a corner of '{}' at {:.6g}, {:.6g}, {:.6g}, not at {:.6g}, {:.6g}, {:.6g}", b.name, there.x,
                             there.y, there.z, here.x, here.y, here.z);
      }
      const Material &of_a = scene.materials[scene.triangle_material[t]], &of_b = other.materials[other.triangle_material[t]];
      if (of_a.double_sided != of_b.double_sided)
        return fmt::format("'{}' with {}", b.name, of_b.double_sided ? "two sides" : "one side");
      if (of_a.veil != of_b.veil) return fmt::format("'{}' with a material that lets other light through", b.name);
    }
  }
  const SkyFaces &sky = scene.light.sky_faces, &other_sky = other.light.sky_faces;
  if (sky.positions != other_sky.positions || sky.triangles != other_sky.triangles) return "other faces of sky";
  return sceneSha256(scene) == sceneSha256(other) ? "" : "vertices in another order, or another box nlg_extent";
}

std::string sceneLightSha256(const Scene& scene) { return sceneLightSha256(scene, scene.light.groups); }

std::string sceneLightSha256(const Scene& scene, const LightGroups& groups) {
  HashedBytes bytes;
  bytes.addText(sceneSha256(scene));
  for (const uint32_t material : scene.triangle_material) {
    bytes.add(scene.materials[material].base_color);
    bytes.add(scene.materials[material].emissive);
  }
  addLooks(scene, bytes);
  const SceneLight& light = scene.light;
  bytes.add(light.sky.zenith);
  bytes.add(light.sky.horizon);
  bytes.add(light.sky.ground);
  if (!light.sky.image.empty()) {
    bytes.add(light.sky.image.width);
    bytes.addCounted(light.sky.image.texels);
  }
  if (!groups.names.empty()) {
    for (const std::string& group : groups.names) bytes.addText(group);
    for (const std::vector<uint8_t>* of_lights : {&groups.of_lamp, &groups.of_sun, &groups.of_material})
      bytes.addCounted(*of_lights);
  }
  bytes.addCounted(light.lamps);
  bytes.addCounted(light.suns);
  bytes.addCounted(light.sky_faces.positions);
  bytes.addCounted(light.sky_faces.triangles);
  bytes.addCounted(light.sky_faces.shine);
  bytes.add(light.baked.page_side);
  bytes.addCounted(light.baked.texels);
  bytes.addCounted(light.baked.triangle_page);
  bytes.addCounted(light.baked.vertex_place);
  bytes.addCounted(light.baked.vertex_light);
  return bytes.hash();
}

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

}  // namespace nlg
