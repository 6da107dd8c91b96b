#include "scene/model/scene.h"

#include <algorithm>
#include <type_traits>

#include <fmt/format.h>

#include "tool/atomic_file.h"

namespace nlg {
namespace {

void grow(Bounds& bounds, const glm::vec3& p, bool is_first) {
  bounds.min = is_first ? p : glm::min(bounds.min, p);
  bounds.max = is_first ? p : glm::max(bounds.max, p);
}

bool isFlat(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return normal.x == 0.0 && normal.y == 0.0 && normal.z == 0.0;
}

void dropFlatTriangles(Scene& scene) {
  std::vector<SceneObject> objects;
  std::vector<int32_t>& pages = scene.light.baked.triangle_page;
  uint32_t kept = 0;
  // what is kept moves forward in place: an object's triangles stay one range
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
    // an object that loses all of its triangles is no object
    if (object.triangle_count > 0) objects.push_back(object);
  }
  scene.dropped_triangle_count = static_cast<uint32_t>(scene.triangles.size()) - kept;
  scene.triangles.resize(kept);
  scene.triangle_material.resize(kept);
  if (!pages.empty()) pages.resize(kept);
  scene.objects = std::move(objects);
}

// What a part of a scene has a say in: functions, and so light, which is made by them; or light alone.
enum class Of : uint8_t { functions, light };

// SHA-256 of the parts that have a say in what is asked for. Lists and texts go in with their lengths: other parts are other bytes.
class PartsHash {
 public:
  explicit PartsHash(Of asked) : asked_(asked) {}
  template <class... Values>
  void add(Of of, const Values&... values) {
    if (of <= asked_) (addOne(values), ...);
  }
  std::string hash() const { return sha256(bytes_); }

 private:
  template <class Value>
  void addOne(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class Value>
  void addOne(const std::vector<Value>& values) {
    addOne(uint64_t{values.size()});
    if constexpr (std::is_trivially_copyable_v<Value>) {
      bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    } else {
      for (const Value& value : values) addOne(value);
    }
  }
  void addOne(const std::string& text) { addOne(std::vector<char>(text.begin(), text.end())); }

  Of asked_;
  std::string bytes_;
};

// ---- The one list of what a bake depends on. Members are bound by name: one that is new does not compile until it is told here what it
// has a say in. Those that are not added have none.

void addParts(const Material& material, PartsHash* parts) {
  const auto& [base_color, emissive, double_sided, transmissive, opacity, transmission, base, shining, transmitting, label] =
      material;
  parts->add(Of::light, base_color, emissive, double_sided, transmissive, opacity, transmission);
  for (const TextureUse& use : {base, shining, transmitting}) {
    const auto& [image, wrap_u, wrap_v] = use;
    parts->add(Of::light, image, wrap_u, wrap_v);
  }
}

// groups   those that the lights are in
void addParts(const SceneLight& light, const LightGroups& groups, PartsHash* parts) {
  const auto& [writer, unit, sky, lamps, suns, lamp_labels, sun_labels, own_groups, sky_faces, baked] = light;
  const auto& [sky_positions, sky_triangles, shine] = sky_faces;
  // whether a place is in solid
  parts->add(Of::functions, sky_positions, sky_triangles);
  static_assert(sizeof(Lamp) == 12 * sizeof(float) && sizeof(Sun) == 7 * sizeof(float), "nothing between members");
  parts->add(Of::light, lamps, suns, shine);
  const auto& [zenith, horizon, ground, image] = sky;
  const auto& [width, height, texels] = image;
  parts->add(Of::light, zenith, horizon, ground, width, height, texels);
  const auto& [page_side, page_texels, triangle_page, vertex_place, vertex_light, ambient] = baked;
  parts->add(Of::light, page_side, page_texels, triangle_page, vertex_place, vertex_light, ambient);
  const auto& [names, of_lamp, of_sun, of_material, of_sky, of_shine, of_baked] = groups;
  if (!names.empty()) parts->add(Of::light, names, of_lamp, of_sun, of_material, of_sky, of_shine, of_baked);
}

std::string sha256Of(const Scene& scene, const LightGroups& groups, Of asked) {
  const auto& [id, origin_m, positions, triangles, triangle_material, materials, images, base_places, emissive_places,
               vertex_colours, objects, dropped_count, light, viewpoints, cavity_m, extent, density] = scene;
  PartsHash parts(asked);
  parts.add(Of::functions, origin_m, positions, triangles, extent.has_value());
  // of cavity_m the file says nothing: it is a setting, limited by sides
  if (extent) parts.add(Of::functions, extent->low_m, extent->high_m);
  for (const DensityBox& of : density) parts.add(Of::functions, of.box.low_m, of.box.high_m, of.spacing_m);
  for (const uint32_t material : triangle_material)
    parts.add(Of::functions, materials[material].double_sided, materials[material].transmissive);
  for (const auto& [name, first_triangle, triangle_count, movable] : objects)
    parts.add(Of::functions, first_triangle, triangle_count, movable);
  for (const Material& material : materials) addParts(material, &parts);
  for (const auto& [width, height, texels] : images) parts.add(Of::light, width, height, texels);
  parts.add(Of::light, triangle_material, base_places, emissive_places, vertex_colours);
  addParts(light, groups, &parts);
  return parts.hash();
}

}  // namespace

Bounds objectBounds(const Scene& scene, const SceneObject& object) {
  Bounds bounds;
  for (uint32_t i = 0; i < object.triangle_count; ++i) {
    const glm::uvec3& triangle = scene.triangles[object.first_triangle + i];
    for (int corner = 0; corner < 3; ++corner) grow(bounds, scene.positions[triangle[corner]], i == 0 && corner == 0);
  }
  return bounds;
}

Bounds geometryBounds(const Scene& scene) {
  Bounds bounds;
  for (size_t i = 0; i < scene.positions.size(); ++i) grow(bounds, scene.positions[i], i == 0);
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

std::string sceneSha256(const Scene& scene) { return sha256Of(scene, {}, Of::functions); }

std::string sceneLightSha256(const Scene& scene) { return sceneLightSha256(scene, scene.light.groups); }

std::string sceneLightSha256(const Scene& scene, const LightGroups& groups) { return sha256Of(scene, groups, Of::light); }

bool hasLightFromOutside(const Scene& scene) {
  const SceneLight& light = scene.light;
  if (!light.baked.empty() || !light.sky_faces.triangles.empty() || light.sky.shines()) return true;
  return std::any_of(light.suns.begin(), light.suns.end(), [](const Sun& sun) { return isBright(sun.irradiance); });
}

}  // namespace nlg
