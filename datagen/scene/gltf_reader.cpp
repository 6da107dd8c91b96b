#include "datagen/scene/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "datagen/scene/gltf_accessor.h"
#include "datagen/scene/gltf_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kDeepestNode = 256;
constexpr uint64_t kMaxTriangles = uint64_t{1} << 27;
constexpr double kFarthest = 1e9;  // metres from the file's origin; beyond, a double no longer holds a tenth of a micrometre

// One mesh in its own coordinates: only vertices that triangles use.
struct LocalMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> triangle_material;
};

bool isTriangleMode(int mode) {
  return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP || mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

uint64_t triangleCount(int mode, uint64_t corner_count) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return corner_count / 3;
  return corner_count < 3 ? 0 : corner_count - 2;
}

// Corners of triangle i in the primitive's list; a strip's odd triangles are turned so that all wind the same way.
glm::uvec3 cornersOf(int mode, uint32_t i) {
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) return {i, i + 1 + i % 2, i + 2 - i % 2};
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

bool isFlat(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return normal.x == 0.0 && normal.y == 0.0 && normal.z == 0.0;
}

class GltfConverter {
 public:
  explicit GltfConverter(const std::string& path)
      : path_(path), model_(loadGltfFile(path)), meshes_(model_.meshes.size()), is_visited_(model_.nodes.size(), 0) {}

  Scene convert() {
    checkExtensions();
    readMaterials();
    for (const int node : rootNodes()) visitNode(node, glm::dmat4(1.0), 0);
    return finish();
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }

  void checkIndex(int idx, size_t count, const std::string& place, const std::string& what) const {
    if (idx >= 0 && static_cast<size_t>(idx) < count) return;
    fail(place, what + " below " + std::to_string(count), std::to_string(idx));
  }

  // Extensions about looks can be missing; those that change where triangles are cannot.
  void checkExtensions() const {
    for (const std::string& name : model_.extensionsRequired) {
      const auto begins = [&](const char* start) { return name.rfind(start, 0) == 0; };
      if (begins("KHR_materials_") || begins("KHR_texture_") || begins("EXT_texture_") || begins("KHR_lights_")) continue;
      fail("extensionsRequired", "extensions of materials, textures and lights", name.substr(0, 80));
    }
  }

  float checkedFactor(double value, double limit, const std::string& place) const {
    // the tolerance is for factors that an exporter computed in float
    if (!(value >= 0.0 && value <= limit * 1.001)) fail(place, "a number from 0 to " + std::to_string(limit), std::to_string(value));
    return static_cast<float>(std::min(value, limit));
  }

  void readMaterials() {
    for (size_t i = 0; i < model_.materials.size(); ++i) {
      const tinygltf::Material& source = model_.materials[i];
      const std::string place = "material " + std::to_string(i);
      const std::vector<double>& base = source.pbrMetallicRoughness.baseColorFactor;
      const double strength = emissiveStrength(source, place);
      Material material;
      for (int channel = 0; channel < 3; ++channel) {
        material.base_color[channel] = checkedFactor(base[channel], 1.0, place + ": baseColorFactor");
        material.emissive[channel] =
            static_cast<float>(strength * checkedFactor(source.emissiveFactor[channel], 1.0, place + ": emissiveFactor"));
      }
      material.double_sided = source.doubleSided;
      scene_.materials.push_back(material);
    }
  }

  double emissiveStrength(const tinygltf::Material& material, const std::string& place) const {
    const auto extension = material.extensions.find("KHR_materials_emissive_strength");
    if (extension == material.extensions.end() || !extension->second.Has("emissiveStrength")) return 1.0;
    return checkedFactor(extension->second.Get("emissiveStrength").GetNumberAsDouble(), 1e12, place + ": emissiveStrength");
  }

  // The material that glTF gives to a primitive without one.
  uint32_t defaultMaterial() {
    if (!default_material_) {
      default_material_ = static_cast<uint32_t>(scene_.materials.size());
      scene_.materials.push_back({glm::vec3(1.0f), glm::vec3(0.0f), false});
    }
    return *default_material_;
  }

  std::vector<int> rootNodes() const {
    if (!model_.scenes.empty()) {
      const int scene_idx = std::max(model_.defaultScene, 0);
      checkIndex(scene_idx, model_.scenes.size(), "scene", "a scene");
      return model_.scenes[scene_idx].nodes;
    }
    std::vector<char> is_child(model_.nodes.size(), 0);
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int child : node.children) {
        if (child >= 0 && static_cast<size_t>(child) < is_child.size()) is_child[child] = 1;
      }
    }
    std::vector<int> roots;
    for (size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    // every node of a ring is a child: start anywhere, and the ring is found
    if (roots.empty() && !is_child.empty()) roots.push_back(0);
    return roots;
  }

  void visitNode(int node_idx, const glm::dmat4& world_from_parent, int depth) {
    const std::string place = "node " + std::to_string(node_idx);
    checkIndex(node_idx, model_.nodes.size(), place, "a node");
    if (is_visited_[node_idx]) fail(place, "a tree of nodes", "a node that is its own ancestor or has two parents");
    if (depth > kDeepestNode) fail(place, "nesting of at most 256 nodes", "more");
    is_visited_[node_idx] = 1;
    const tinygltf::Node& node = model_.nodes[node_idx];
    const glm::dmat4 world_from_local = world_from_parent * localTransform(node, place);
    if (node.mesh >= 0) addInstance(node, node_idx, world_from_local, place);
    for (const int child : node.children) visitNode(child, world_from_local, depth + 1);
  }

  // Lengths and that there is a matrix or the other three, not both, the text has been checked for.
  glm::dmat4 localTransform(const tinygltf::Node& node, const std::string& place) const {
    glm::dmat4 local(1.0);
    if (!node.matrix.empty()) {
      for (int i = 0; i < 16; ++i) local[i / 4][i % 4] = node.matrix[i];
      const bool is_affine = local[0][3] == 0.0 && local[1][3] == 0.0 && local[2][3] == 0.0 && local[3][3] == 1.0;
      if (!is_affine) fail(place + ": matrix", "0 0 0 1 as its last row", "another");
    }
    if (!node.rotation.empty()) local = rotationMatrix(node.rotation, place);
    for (int axis = 0; axis < 3 && !node.scale.empty(); ++axis) local[axis] *= node.scale[axis];
    if (!node.translation.empty()) local[3] = {node.translation[0], node.translation[1], node.translation[2], 1.0};
    return local;
  }

  glm::dmat4 rotationMatrix(const std::vector<double>& q, const std::string& place) const {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6 && length < 1e6)) fail(place + ": rotation", "a unit quaternion", "length " + std::to_string(length));
    const double x = q[0] / length;
    const double y = q[1] / length;
    const double z = q[2] / length;
    const double w = q[3] / length;
    glm::dmat4 m(1.0);
    m[0] = {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w), 0.0};
    m[1] = {2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w), 0.0};
    m[2] = {2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y), 0.0};
    return m;
  }

  void addInstance(const tinygltf::Node& node, int node_idx, const glm::dmat4& world_from_local, const std::string& place) {
    checkIndex(node.mesh, model_.meshes.size(), place + ": mesh", "a mesh");
    const LocalMesh& mesh = localMesh(node.mesh);
    checkTotal(mesh.triangles.size(), place);
    if (mesh.triangles.empty()) return;
    const std::string& mesh_name = model_.meshes[node.mesh].name;
    const std::string name = !node.name.empty() ? node.name : !mesh_name.empty() ? mesh_name : "node " + std::to_string(node_idx);
    scene_.objects.push_back({name, static_cast<uint32_t>(scene_.triangles.size()), static_cast<uint32_t>(mesh.triangles.size()), true});

    const auto base = static_cast<uint32_t>(world_positions_.size());
    for (const glm::vec3& p : mesh.positions) {
      const glm::dvec3 world(world_from_local * glm::dvec4(glm::dvec3(p), 1.0));
      for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(world[axis]) <= kFarthest)) fail(place, "positions within 1e9 m of the origin", std::to_string(world[axis]));
      }
      world_positions_.push_back(world);
    }
    const bool is_mirrored = glm::determinant(glm::dmat3(world_from_local)) < 0.0;
    for (glm::uvec3 triangle : mesh.triangles) {
      if (is_mirrored) std::swap(triangle.y, triangle.z);
      scene_.triangles.push_back(triangle + base);
    }
    scene_.triangle_material.insert(scene_.triangle_material.end(), mesh.triangle_material.begin(), mesh.triangle_material.end());
  }

  void checkTotal(uint64_t more, const std::string& place) const {
    const uint64_t total = scene_.triangles.size() + more;
    if (total > kMaxTriangles) fail(place, "at most 2^27 triangles in all", std::to_string(total));
  }

  const LocalMesh& localMesh(int mesh_idx) {
    if (!meshes_[mesh_idx]) {
      LocalMesh local;
      const tinygltf::Mesh& mesh = model_.meshes[mesh_idx];
      for (size_t i = 0; i < mesh.primitives.size(); ++i) {
        addPrimitive(mesh.primitives[i], "mesh " + std::to_string(mesh_idx) + ", primitive " + std::to_string(i), local);
      }
      meshes_[mesh_idx] = std::move(local);
    }
    return *meshes_[mesh_idx];
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const std::string& place, LocalMesh& local) {
    const int mode = primitive.mode;
    if (mode < 0 || mode > TINYGLTF_MODE_TRIANGLE_FAN) fail(place + ": mode", "0 to 6", std::to_string(mode));
    if (!isTriangleMode(mode)) return;
    const AccessorReader positions = positionReader(primitive, place);
    const std::vector<uint32_t> corners = readCorners(primitive, positions.count(), place, local.triangles.size());
    const uint32_t material = materialOf(primitive, place);

    std::vector<uint32_t> used = corners;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto base = static_cast<uint32_t>(local.positions.size());
    for (const uint32_t idx : used) local.positions.push_back(readPosition(positions, idx, place));
    const auto compact = [&](uint32_t corner) {
      return base + static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), corners[corner]) - used.begin());
    };
    const auto triangle_count = static_cast<uint32_t>(triangleCount(mode, corners.size()));
    for (uint32_t i = 0; i < triangle_count; ++i) {
      const glm::uvec3 corner = cornersOf(mode, i);
      local.triangles.emplace_back(compact(corner.x), compact(corner.y), compact(corner.z));
      local.triangle_material.push_back(material);
    }
  }

  AccessorReader positionReader(const tinygltf::Primitive& primitive, const std::string& place) {
    const auto attribute = primitive.attributes.find("POSITION");
    place_ = place + ": POSITION";
    if (attribute == primitive.attributes.end()) fail(place_, "FLOAT VEC3", "none");
    checkIndex(attribute->second, model_.accessors.size(), place_, "an accessor");
    const tinygltf::Accessor& accessor = model_.accessors[attribute->second];
    if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT || accessor.type != TINYGLTF_TYPE_VEC3) {
      fail(place_, "FLOAT VEC3", "component type " + std::to_string(accessor.componentType) + ", type " + std::to_string(accessor.type));
    }
    return AccessorReader(model_, attribute->second, path_, place_);
  }

  // The primitive's list of vertices, all below vertex_count.
  std::vector<uint32_t> readCorners(const tinygltf::Primitive& primitive, uint64_t vertex_count, const std::string& place,
                                    uint64_t triangles_before) {
    const bool is_indexed = primitive.indices >= 0;
    const std::string indices_place = place + ": indices";
    const std::optional<AccessorReader> indices =
        is_indexed ? std::optional(indexReader(primitive.indices, indices_place)) : std::nullopt;
    const uint64_t count = is_indexed ? indices->count() : vertex_count;
    checkTotal(triangles_before + triangleCount(primitive.mode, count), place);
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES && count % 3 != 0) fail(place, "a multiple of 3 corners", std::to_string(count));
    std::vector<uint32_t> corners(count);
    const int byte_count =
        is_indexed ? tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(model_.accessors[primitive.indices].componentType)) : 0;
    for (uint64_t i = 0; i < count; ++i) {
      const unsigned char* bytes = is_indexed ? indices->element(i) : nullptr;
      corners[i] = bytes != nullptr ? readUnsigned(bytes, byte_count) : is_indexed ? 0 : static_cast<uint32_t>(i);
      if (corners[i] < vertex_count) continue;
      fail(indices_place, "indices below " + std::to_string(vertex_count), std::to_string(corners[i]) + " at " + std::to_string(i));
    }
    return corners;
  }

  AccessorReader indexReader(int accessor_idx, const std::string& place) const {
    checkIndex(accessor_idx, model_.accessors.size(), place, "an accessor");
    const tinygltf::Accessor& accessor = model_.accessors[accessor_idx];
    const int type = accessor.componentType;
    const bool is_unsigned = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                             type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (!is_unsigned || accessor.type != TINYGLTF_TYPE_SCALAR) {
      fail(place, "unsigned SCALAR of 8, 16 or 32 bits", "component type " + std::to_string(type) + ", type " + std::to_string(accessor.type));
    }
    return AccessorReader(model_, accessor_idx, path_, place);
  }

  uint32_t materialOf(const tinygltf::Primitive& primitive, const std::string& place) {
    if (primitive.material < 0) return defaultMaterial();
    checkIndex(primitive.material, model_.materials.size(), place + ": material", "a material");
    return static_cast<uint32_t>(primitive.material);
  }

  glm::vec3 readPosition(const AccessorReader& positions, uint32_t idx, const std::string& place) const {
    glm::vec3 p(0.0f);
    if (const unsigned char* bytes = positions.element(idx)) std::memcpy(&p, bytes, sizeof p);
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(p[axis])) fail(place + ": POSITION", "finite numbers", std::to_string(p[axis]) + " at vertex " + std::to_string(idx));
    }
    return p;
  }

  // Moves the origin to the middle, on whole metres, and drops triangles of zero area and objects that have no other.
  Scene finish() {
    scene_.id = std::filesystem::path(path_).stem().string();
    if (!world_positions_.empty()) {
      glm::dvec3 low = world_positions_[0];
      glm::dvec3 high = low;
      for (const glm::dvec3& p : world_positions_) {
        low = glm::min(low, p);
        high = glm::max(high, p);
      }
      scene_.origin_m = glm::round(0.5 * (low + high));
    }
    scene_.positions.reserve(world_positions_.size());
    for (const glm::dvec3& p : world_positions_) scene_.positions.emplace_back(p - scene_.origin_m);
    dropFlatTriangles();
    return std::move(scene_);
  }

  void dropFlatTriangles() {
    std::vector<SceneObject> objects;
    uint32_t kept = 0;
    for (SceneObject object : scene_.objects) {
      const uint32_t end = object.first_triangle + object.triangle_count;
      const uint32_t first_kept = kept;
      for (uint32_t i = object.first_triangle; i < end; ++i) {
        const glm::uvec3 t = scene_.triangles[i];
        if (isFlat(scene_.positions[t.x], scene_.positions[t.y], scene_.positions[t.z])) continue;
        scene_.triangles[kept] = t;
        scene_.triangle_material[kept++] = scene_.triangle_material[i];
      }
      object.first_triangle = first_kept;
      object.triangle_count = kept - first_kept;
      if (object.triangle_count > 0) objects.push_back(object);
    }
    scene_.dropped_triangle_count = static_cast<uint32_t>(scene_.triangles.size()) - kept;
    scene_.triangles.resize(kept);
    scene_.triangle_material.resize(kept);
    scene_.objects = std::move(objects);
  }

  const std::string path_;
  const tinygltf::Model model_;
  std::vector<std::optional<LocalMesh>> meshes_;
  std::vector<char> is_visited_;
  std::vector<glm::dvec3> world_positions_;
  std::optional<uint32_t> default_material_;
  std::string place_;  // of the accessor being read
  Scene scene_;
};

}  // namespace

Scene readGltf(const std::string& path) { return GltfConverter(path).convert(); }

}  // namespace nlg
