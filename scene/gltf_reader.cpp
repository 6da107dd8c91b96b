#include "scene/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "scene/gltf_accessor.h"
#include "scene/gltf_file.h"
#include "scene/gltf_light.h"
#include "scene/gltf_looks.h"
#include "scene/gltf_mesh.h"
#include "scene/gltf_unread.h"
#include "scene/veils.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr int kDeepestNode = 256;
constexpr double kFarthest = 1e9;  // metres from the file's origin; beyond, a double no longer holds a tenth of a micrometre

class GltfConverter {
 public:
  GltfConverter(const std::string& path, double unit_m, double dense_veil, ImageNeed need)
      : path_(path),
        unit_m_(unit_m),
        dense_veil_(dense_veil),
        model_(loadGltfFile(path, budgets_.bytes)),
        looks_(readGltfLooks(path_, model_, budgets_, &notes_, need)),
        meshes_(model_.meshes.size()),
        is_visited_(model_.nodes.size(), 0) {}

  GltfLevel convert() {
    lights_ = readGltfLights(path_, model_, &notes_);
    scene_.light.writer = isOfBlender(model_) ? LightWriter::blender : LightWriter::gltf;
    const glm::dmat4 metres_from_units{glm::dmat3(unit_m_)};
    for (const int node : rootNodes()) visitNode(node, metres_from_units, 0);
    return finish();
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }

  std::vector<int> rootNodes() const {
    if (!model_.scenes.empty()) {
      const int scene_idx = std::max(model_.defaultScene, 0);
      requireIndex(scene_idx, model_.scenes.size(), path_, "scene", "a scene");
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
    requireIndex(node_idx, model_.nodes.size(), path_, place, "a node");
    if (is_visited_[node_idx]) fail(place, "a tree of nodes", "a node that is its own ancestor or has two parents");
    if (depth > kDeepestNode) fail(place, "nesting of at most 256 nodes", "more");
    is_visited_[node_idx] = 1;
    const tinygltf::Node& node = model_.nodes[node_idx];
    const glm::dmat4 world_from_local = world_from_parent * localTransform(node, place);
    if (isExtent(node)) {
      addExtent(node, world_from_local, place);
    } else if (node.mesh >= 0) {
      addInstance(node, node_idx, world_from_local, place);
    }
    const int light = lightOfNode(path_, place, node, lights_.size());
    if (light >= 0 && !lights_[light].is_left_out) addLight(lights_[light], node, world_from_local, place);
    if (node.camera >= 0) addCamera(node, world_from_local, place);
    for (const int child : node.children) visitNode(child, world_from_local, depth + 1);
  }

  // Blender numbers names that it has twice: nlg_extent.001.
  static bool isExtent(const tinygltf::Node& node) {
    const bool is_marked = node.extras.IsObject() && node.extras.Has("nlg_extent") && node.extras.Get("nlg_extent").IsBool() &&
                           node.extras.Get("nlg_extent").Get<bool>();
    return is_marked || node.name == "nlg_extent" || node.name.rfind("nlg_extent.", 0) == 0;
  }

  // The box around its mesh, or around the cube from -1 to 1 that an empty stands for; around all such nodes together.
  void addExtent(const tinygltf::Node& node, const glm::dmat4& world_from_local, const std::string& place) {
    std::vector<glm::vec3> corners = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                      {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
    if (node.mesh >= 0) {
      requireIndex(node.mesh, model_.meshes.size(), path_, place + ": mesh", "a mesh");
      corners = localMesh(node.mesh).positions;
    }
    for (const glm::vec3& corner : corners) {
      const glm::dvec3 world(world_from_local * glm::dvec4(glm::dvec3(corner), 1.0));
      checkPosition(world, place);
      if (!scene_.extent) scene_.extent = ExtentBox{world, world};
      scene_.extent->low_m = glm::min(scene_.extent->low_m, world);
      scene_.extent->high_m = glm::max(scene_.extent->high_m, world);
    }
  }

  // Perspective cameras: no view of a level is without perspective.
  void addCamera(const tinygltf::Node& node, const glm::dmat4& world_from_local, const std::string& place) {
    requireIndex(node.camera, model_.cameras.size(), path_, place + ": camera", "a camera");
    const tinygltf::Camera& camera = model_.cameras[node.camera];
    if (camera.type != "perspective") return;
    const double fov_y = camera.perspective.yfov;
    if (!(fov_y > 0.0 && fov_y < 3.1415926))
      fail("camera " + std::to_string(node.camera) + ": yfov", "a number between 0 and pi", std::to_string(fov_y));
    const glm::dvec3 forward = -glm::dvec3(world_from_local[2]), right(world_from_local[0]);
    const glm::dvec3 up = glm::cross(right, forward);
    if (!(glm::length(forward) > 0.0 && glm::length(up) > 0.0)) fail(place + ": camera", "a node with a direction", "scale 0");
    checkPosition(glm::dvec3(world_from_local[3]), place);
    viewpoint_positions_.emplace_back(world_from_local[3]);
    const std::string name = !node.name.empty() ? node.name : camera.name;
    scene_.viewpoints.push_back(
        {name, glm::vec3(0.0f), glm::vec3(glm::normalize(forward)), glm::vec3(glm::normalize(up)), static_cast<float>(fov_y)});
  }

  // What artists name and mark is the object that carries a light.
  static LightLabel labelOf(const GltfLight& light, const tinygltf::Node& node) {
    const std::string group = lightGroupOf(node.extras);
    return {!node.name.empty() ? node.name : light.label.name, !group.empty() ? group : light.label.group};
  }

  void addLight(const GltfLight& light, const tinygltf::Node& node, const glm::dmat4& world_from_local,
                const std::string& place) {
    const glm::dvec3 forward = -glm::dvec3(world_from_local[2]), position(world_from_local[3]);
    const double length = glm::length(forward);
    const bool has_direction = length > 0.0;
    if (!has_direction && (light.is_sun || light.is_spot)) {
      notes_.push_back(place + ": a light that points nowhere, its scale is 0; left out");
      return;
    }
    // which way a lamp that shines all round points is the same
    const glm::dvec3 direction = has_direction ? forward / length : glm::dvec3(0.0, -1.0, 0.0);
    if (light.is_sun) {
      scene_.light.suns.push_back(sunOf(light, direction));
      scene_.light.sun_labels.push_back(labelOf(light, node));
      return;
    }
    checkPosition(position, place);
    scene_.light.lamps.push_back(lampOf(light, direction));
    scene_.light.lamp_labels.push_back(labelOf(light, node));
    lamp_positions_.push_back(position);
  }

  void checkPosition(const glm::dvec3& world, const std::string& place) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (!(std::abs(world[axis]) <= kFarthest)) fail(place, "positions within 1e9 m of the origin", std::to_string(world[axis]));
    }
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
    requireIndex(node.mesh, model_.meshes.size(), path_, place + ": mesh", "a mesh");
    const GltfMesh& mesh = localMesh(node.mesh);
    triangles_left_.take(mesh.triangles.size(), path_, place);
    if (mesh.triangles.empty()) return;
    const std::string& mesh_name = model_.meshes[node.mesh].name;
    const std::string name = !node.name.empty() ? node.name : !mesh_name.empty() ? mesh_name : "node " + std::to_string(node_idx);
    scene_.objects.push_back(
        {name, static_cast<uint32_t>(scene_.triangles.size()), static_cast<uint32_t>(mesh.triangles.size()), true});

    const auto base = static_cast<uint32_t>(world_positions_.size());
    for (const glm::vec3& p : mesh.positions) {
      const glm::dvec3 world(world_from_local * glm::dvec4(glm::dvec3(p), 1.0));
      checkPosition(world, place);
      world_positions_.push_back(world);
    }
    addLooks(mesh);
    const bool is_mirrored = glm::determinant(glm::dmat3(world_from_local)) < 0.0;
    for (glm::uvec3 triangle : mesh.triangles) {
      if (is_mirrored) std::swap(triangle.y, triangle.z);
      scene_.triangles.push_back(triangle + base);
    }
    scene_.triangle_material.insert(scene_.triangle_material.end(), mesh.triangle_material.begin(), mesh.triangle_material.end());
  }

  const GltfMesh& localMesh(int mesh_idx) {
    if (!meshes_[mesh_idx]) {
      meshes_[mesh_idx] = readGltfMesh(model_, mesh_idx, looks_, path_, budgets_);
      unplaced_count_ += meshes_[mesh_idx]->unplaced_count;
    }
    return *meshes_[mesh_idx];
  }

  // What stands beside the positions of a mesh.
  void addLooks(const GltfMesh& mesh) {
    const auto append = [](const auto& from, auto& to) { to.insert(to.end(), from.begin(), from.end()); };
    append(mesh.base_places, scene_.base_places);
    append(mesh.emissive_places, scene_.emissive_places);
    if (mesh.colours.empty() && scene_.vertex_colours.empty()) return;
    // white, where a mesh has none
    scene_.vertex_colours.resize(world_positions_.size() - mesh.positions.size(), glm::vec4(1.0f));
    append(mesh.colours, scene_.vertex_colours);
    scene_.vertex_colours.resize(world_positions_.size(), glm::vec4(1.0f));
  }

  // The one of primitives without stands last, where there are any.
  void takeMaterials() {
    scene_.materials = std::move(looks_.materials);
    const std::vector<uint32_t>& used = scene_.triangle_material;
    if (std::find(used.begin(), used.end(), scene_.materials.size() - 1) == used.end()) scene_.materials.pop_back();
  }

  void noteLosses() {
    const auto append = [&](std::vector<std::string> lines) { notes_.insert(notes_.end(), lines.begin(), lines.end()); };
    if (unplaced_count_ > 0)
      notes_.push_back(std::to_string(unplaced_count_) +
                       " primitives have an image, and not all of their places on it (TEXCOORD): its corner instead");
    append(judgeVeils(scene_, looks_.names, dense_veil_));
    append(unreadParts(model_));
  }

  GltfLevel finish() {
    scene_.id = std::filesystem::path(path_).stem().string();
    const auto isWhite = [](const glm::vec4& colour) { return colour == glm::vec4(1.0f); };
    if (std::all_of(scene_.vertex_colours.begin(), scene_.vertex_colours.end(), isWhite)) scene_.vertex_colours.clear();
    scene_.images = std::move(looks_.images);
    takeMaterials();
    finishScene(scene_, world_positions_);
    const std::vector<glm::vec3> lamp_positions = relativeTo(scene_.origin_m, lamp_positions_);
    for (size_t i = 0; i < lamp_positions.size(); ++i) scene_.light.lamps[i].position = lamp_positions[i];
    const std::vector<glm::vec3> eyes = relativeTo(scene_.origin_m, viewpoint_positions_);
    for (size_t i = 0; i < eyes.size(); ++i) scene_.viewpoints[i].position = eyes[i];
    noteLosses();
    return {std::move(scene_), std::move(notes_)};
  }

  const std::string path_;
  const double unit_m_, dense_veil_;
  SceneBudgets budgets_;                                   // of the file: each mesh once
  SceneBudget triangles_left_ = SceneBudgets().triangles;  // of the scene: each instance
  const tinygltf::Model model_;
  std::vector<std::string> notes_;
  GltfLooks looks_;
  std::vector<std::optional<GltfMesh>> meshes_;
  std::vector<char> is_visited_;
  std::vector<glm::dvec3> world_positions_;
  std::vector<glm::dvec3> viewpoint_positions_;
  std::vector<GltfLight> lights_;
  std::vector<glm::dvec3> lamp_positions_;  // of the scene's lamps, world coordinates
  Scene scene_;
  uint32_t unplaced_count_ = 0;  // GltfMesh's, of all meshes
};

}  // namespace

GltfLevel readGltf(const std::string& path, double unit_m, double dense_veil, ImageNeed need) {
  return GltfConverter(path, unit_m, dense_veil, need).convert();
}

}  // namespace nlg
