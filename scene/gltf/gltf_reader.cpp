#include "scene/gltf/gltf_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_file.h"
#include "scene/gltf/gltf_light.h"
#include "scene/gltf/gltf_looks.h"
#include "scene/gltf/gltf_mesh.h"
#include "scene/gltf/gltf_nodes.h"
#include "scene/gltf/gltf_unread.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr char kRead = 1, kLeftOut = 2;  // of nodes

class GltfConverter {
 public:
  GltfConverter(const std::string& path, double unit_m, double dense_transmissive, const GltfChoice& choice, ImageNeed need)
      : path_(path),
        dense_transmissive_(dense_transmissive),
        odd_(path),
        model_(loadGltfFile(path, budgets_.bytes, &odd_)),
        parents_(parentsOf(model_)),
        scene_idx_(chosenScene(choice.scene_name)),
        roots_(rootNodes()),
        verdicts_(judgeNodes(model_, roots_, choice.leave_out, &notes_)),
        looks_(readGltfLooks(path_, model_, budgets_, &notes_, &odd_, need)),
        metres_from_units_(glm::dmat3(unit_m)),
        meshes_(model_.meshes.size()),
        is_visited_(model_.nodes.size(), 0) {}

  GltfLevel convert() {
    lights_ = readGltfLights(path_, model_, &odd_);
    scene_.light.writer = isOfBlender(model_) ? LightWriter::blender : LightWriter::gltf;
    scene_.light.unit = unitOfLights(model_, lights_);
    const std::string lost = noteOfLostSuns(model_, lights_);
    if (!lost.empty()) notes_.push_back(lost);
    visitNodes();
    if (scene_.triangles.empty() && odd_.first()) throw InputError(*odd_.first());
    noteOthers();
    return finish();
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }

  std::string sceneName(size_t idx) const {
    return model_.scenes[idx].name.empty() ? std::to_string(idx + 1) : model_.scenes[idx].name;
  }

  // -1: the file has none.
  int chosenScene(const std::string& name) {
    const auto count = static_cast<int>(model_.scenes.size());
    std::vector<std::string> known;
    for (int i = 0; i < count; ++i) {
      known.push_back(sceneName(static_cast<size_t>(i)));
      if (!name.empty() && (known.back() == name || std::to_string(i + 1) == name)) return i;
    }
    if (!name.empty()) throw UsageError("--scene-name", "a scene of " + path_ + ": " + listed(known), name);
    if (model_.defaultScene < count) return std::min(std::max(model_.defaultScene, 0), count - 1);
    odd_.add("the first one instead", fmt::format("scene {} of {} by default", model_.defaultScene + 1, count));
    return std::min(0, count - 1);
  }

  // By node: the one that it hangs on; -1: none.
  static std::vector<int> parentsOf(const tinygltf::Model& model) {
    std::vector<int> parents(model.nodes.size(), -1);
    for (size_t i = 0; i < parents.size(); ++i) {
      for (const int child : model.nodes[i].children) {
        if (child >= 0 && static_cast<size_t>(child) < parents.size()) parents[static_cast<size_t>(child)] = static_cast<int>(i);
      }
    }
    return parents;
  }

  std::vector<int> rootNodes() const {
    if (scene_idx_ >= 0) return model_.scenes[static_cast<size_t>(scene_idx_)].nodes;
    std::vector<int> roots;
    for (size_t i = 0; i < parents_.size(); ++i) {
      if (parents_[i] < 0) roots.push_back(static_cast<int>(i));
    }
    // every node of a ring is a child: start anywhere
    if (roots.empty() && !parents_.empty()) roots.push_back(0);
    return roots;
  }

  struct NodeToVisit {
    int node_idx;
    glm::dmat4 world_from_parent;
  };

  // A node before its children, the first of them first; however deep a file nests them.
  void visitNodes() {
    std::vector<NodeToVisit> left;
    const auto push = [&](const std::vector<int>& nodes, const glm::dmat4& world_from_parent) {
      for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) left.push_back({*node, world_from_parent});
    };
    push(roots_, metres_from_units_);
    while (!left.empty()) {
      const NodeToVisit next = left.back();
      left.pop_back();
      glm::dmat4 world_from_local(1.0);
      bool has_children = false;
      odd_.attempt(Oddities::kLeftOut,
                   [&] { has_children = visitNode(next.node_idx, next.world_from_parent, &world_from_local); });
      if (has_children) push(model_.nodes[static_cast<size_t>(next.node_idx)].children, world_from_local);
    }
  }

  // to_children   receives their world_from_parent
  // returns       whether they are to be visited
  bool visitNode(int node_idx, const glm::dmat4& world_from_parent, glm::dmat4* to_children) {
    const std::string place = "node " + std::to_string(node_idx);
    requireIndex(node_idx, model_.nodes.size(), path_, place, "a node");
    if (is_visited_[node_idx] == kLeftOut) return false;
    if (is_visited_[node_idx]) fail(place, "a tree of nodes", "a node that is its own ancestor or has two parents");
    const tinygltf::Node& node = model_.nodes[node_idx];
    const NodeVerdict& verdict = verdicts_[static_cast<size_t>(node_idx)];
    if (verdict.with_children) {
      tally({node_idx}, &left_out_[verdict.why]);
      return false;
    }
    is_visited_[node_idx] = kRead;
    tally(coarserNodes(model_, node), &left_out_[kCoarserNodes]);
    const glm::dmat4 world_from_local = world_from_parent * localTransform(node, place);
    const auto attempt = [&](const auto& step) { odd_.attempt(Oddities::kLeftOut, step); };
    const bool has_density = node.extras.IsObject() && node.extras.Has("nlg_density");
    if (has_density) attempt([&] { addDensity(node, node_idx, world_from_local, place); });
    if (isExtent(node)) {
      attempt([&] { addExtent(node, world_from_local, place); });
    } else if (has_density) {
      // its mesh is a box, and no geometry
    } else if (!verdict.why.empty() && node.mesh >= 0) {
      left_out_[verdict.why].objects.push_back(nodeName(model_, node_idx));
    } else if (node.mesh >= 0) {
      attempt([&] { addMesh(node, node_idx, world_from_local, place); });
      if (!lightGroupOf(node.extras).empty() && lightOfNode(path_, place, node, lights_.size()) < 0)
        odd_.add("light_group of a mesh, which has no effect: its material may have one", nodeName(model_, node_idx));
    }
    attempt([&] {
      const int light = lightOfNode(path_, place, node, lights_.size());
      if (light >= 0 && !lights_[light].is_left_out) addLight(lights_[light], node, world_from_local, place);
    });
    if (node.camera >= 0) attempt([&] { addCamera(node, world_from_local, place); });
    *to_children = world_from_local;
    return true;
  }

  // Counts what these nodes hold, with all that hangs on them, and is not read.
  void tally(std::vector<int> nodes, NodeHoldings* holdings) {
    for (size_t i = 0; i < nodes.size(); ++i) {
      const auto node = static_cast<size_t>(nodes[i]);
      if (node >= is_visited_.size() || is_visited_[node]) continue;
      is_visited_[node] = kLeftOut;
      holdings->add(model_, nodes[i]);
      nodes.insert(nodes.end(), model_.nodes[node].children.begin(), model_.nodes[node].children.end());
    }
  }

  // What was left out, and what no root reaches.
  void noteOthers() {
    const auto note = [&](const NodeHoldings& holdings, const std::string& before, const std::string& behind) {
      const std::string text = holdings.text();
      if (!text.empty()) notes_.push_back(before + text + behind);
    };
    for (const auto& [why, holdings] : left_out_) {
      const bool is_guess = why.find(" name") != std::string::npos;
      note(holdings, "", " left out, " + why + (is_guess ? "; an extra nlg_ignore of false keeps a node" : ""));
    }
    // what is left out of this scene another may show
    const std::vector<char> visited = is_visited_;
    std::replace(is_visited_.begin(), is_visited_.end(), kLeftOut, char{0});
    for (size_t s = 0; s < model_.scenes.size(); ++s) {
      NodeHoldings others;
      if (static_cast<int>(s) != scene_idx_) tally(model_.scenes[s].nodes, &others);
      note(others, fmt::format("scene {} of {} is not read: ", s + 1, model_.scenes.size()), "; --scene-name " + sceneName(s));
    }
    NodeHoldings lost;
    for (size_t i = 0; i < visited.size(); ++i) {
      if (!visited[i]) tally({static_cast<int>(i)}, &lost);
    }
    note(lost, "in no scene of the file, and not read: ", "");
  }

  // Blender numbers names that it has twice: nlg_extent.001.
  static bool isExtent(const tinygltf::Node& node) {
    return isMarked(node, "nlg_extent") || node.name == "nlg_extent" || node.name.rfind("nlg_extent.", 0) == 0;
  }

  // Around all such nodes together.
  void addExtent(const tinygltf::Node& node, const glm::dmat4& world_from_local, const std::string& place) {
    const ExtentBox box = boxOf(node, world_from_local, place);
    if (!scene_.extent) scene_.extent = box;
    scene_.extent->low_m = glm::min(scene_.extent->low_m, box.low_m);
    scene_.extent->high_m = glm::max(scene_.extent->high_m, box.high_m);
  }

  void addDensity(const tinygltf::Node& node, int node_idx, const glm::dmat4& world_from_local, const std::string& place) {
    const tinygltf::Value& extra = node.extras.Get("nlg_density");
    const double spacing_m = extra.IsNumber() ? extra.GetNumberAsDouble() : -1.0;
    if (!(spacing_m >= 0.0 && std::isfinite(spacing_m)))
      fail(place + " '" + node.name + "': nlg_density", "metres between probes, or 0 for none",
           extra.IsNumber() ? fmt::format("{:g}", spacing_m) : "no number");
    scene_.density.push_back({boxOf(node, world_from_local, place), spacing_m, nodeName(model_, node_idx).substr(0, 100)});
  }

  // Around its mesh, or around the cube from -1 to 1 that an empty stands for.
  ExtentBox boxOf(const tinygltf::Node& node, const glm::dmat4& world_from_local, const std::string& place) {
    std::vector<glm::vec3> corners = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                      {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
    if (node.mesh >= 0) {
      requireIndex(node.mesh, model_.meshes.size(), path_, place + ": mesh", "a mesh");
      corners = localMesh(node.mesh).positions;
    }
    ExtentBox box{glm::dvec3(HUGE_VAL), glm::dvec3(-HUGE_VAL)};
    for (const glm::vec3& corner : corners) {
      const glm::dvec3 world(world_from_local * glm::dvec4(glm::dvec3(corner), 1.0));
      checkPosition(world, place);
      box = {glm::min(box.low_m, world), glm::max(box.high_m, world)};
    }
    return box;
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
      odd_.add("a light that points nowhere, its scale is 0; left out", place);
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
      if (!(std::abs(world[axis]) <= kFarthestM))
        fail(place, "positions within 1e9 m of the origin", std::to_string(world[axis]));
    }
  }

  // Lengths the text has been checked for.
  glm::dmat4 localTransform(const tinygltf::Node& node, const std::string& place) const {
    glm::dmat4 local(1.0);
    if (!node.matrix.empty()) {
      for (int i = 0; i < 16; ++i) local[i / 4][i % 4] = node.matrix[i];
      const bool is_affine = local[0][3] == 0.0 && local[1][3] == 0.0 && local[2][3] == 0.0 && local[3][3] == 1.0;
      if (!is_affine) fail(place + ": matrix", "0 0 0 1 as its last row", "another");
      return local;
    }
    if (!node.rotation.empty()) local = rotationMatrix(node.rotation, place);
    for (int axis = 0; axis < 3 && !node.scale.empty(); ++axis) local[axis] *= node.scale[axis];
    if (!node.translation.empty()) local[3] = {node.translation[0], node.translation[1], node.translation[2], 1.0};
    return local;
  }

  glm::dmat4 rotationMatrix(const std::vector<double>& q, const std::string& place) const {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6 && length < 1e6)) fail(place + ": rotation", "a unit quaternion", "length " + std::to_string(length));
    return glm::mat4_cast(glm::dquat(q[3] / length, q[0] / length, q[1] / length, q[2] / length));
  }

  // A node's mesh: in the pose of its skin and of its own weights, or as all nodes have it; once, or as often as it is instanced.
  void addMesh(const tinygltf::Node& node, int node_idx, const glm::dmat4& world_from_local, const std::string& place) {
    requireIndex(node.mesh, model_.meshes.size(), path_, place + ": mesh", "a mesh");
    std::vector<glm::dmat4> world_from_mesh = instancesOf(node, world_from_local, place + ": EXT_mesh_gpu_instancing");
    std::optional<GltfMesh> posed;
    if (node.skin >= 0 || !node.weights.empty()) {
      GltfPose pose{node.weights.empty() ? model_.meshes[node.mesh].weights : node.weights, {}};
      if (node.skin >= 0) {
        pose.joints = jointsOf(node.skin, place + ": skin");
        // where the skin is, so that floats hold it; the node's own place is nothing to it
        const glm::dvec3 middle(pose.joints[0][3]);
        for (glm::dmat4& joint : pose.joints) joint[3] -= glm::dvec4(middle, 0.0);
        world_from_mesh = {glm::dmat4(1.0)};
        world_from_mesh[0][3] = {middle, 1.0};
      }
      posed = readMesh(node.mesh, pose);
    }
    const GltfMesh& mesh = posed ? *posed : localMesh(node.mesh);
    for (size_t i = 0; i < world_from_mesh.size(); ++i)
      addInstance(mesh, nodeName(model_, node_idx) + (world_from_mesh.size() == 1 ? "" : " " + std::to_string(i)),
                  world_from_mesh[i], place);
  }

  // Of each joint, where it takes what is bound to it: its node's place times its inverse bind matrix.
  std::vector<glm::dmat4> jointsOf(int skin_idx, const std::string& place) {
    requireIndex(skin_idx, model_.skins.size(), path_, place, "a skin");
    const tinygltf::Skin& skin = model_.skins[static_cast<size_t>(skin_idx)];
    if (skin.joints.empty()) fail(place, "joints", "none");
    std::vector<float> inverse;
    if (skin.inverseBindMatrices >= 0)
      inverse = readNumbers(model_, skin.inverseBindMatrices, 16, 16, nullptr, skin.joints.size(), path_, place, budgets_);
    budgets_.accessor_elements.take(skin.joints.size(), path_, place);
    std::vector<glm::dmat4> joints;
    for (size_t i = 0; i < skin.joints.size(); ++i)
      joints.push_back(worldOf(skin.joints[i], place) *
                       (inverse.empty() ? glm::dmat4(1.0) : glm::dmat4(glm::make_mat4(&inverse[16 * i]))));
    return joints;
  }

  glm::dmat4 worldOf(int node_idx, const std::string& place) {
    requireIndex(node_idx, model_.nodes.size(), path_, place, "a node");
    const auto [world, is_new] = worlds_.try_emplace(node_idx, 1.0);
    // a ring has no top
    size_t depth = 0;
    for (int at = node_idx; is_new && at >= 0 && depth < parents_.size(); at = parents_[static_cast<size_t>(at)], ++depth)
      world->second = localTransform(model_.nodes[static_cast<size_t>(at)], place) * world->second;
    if (is_new) world->second = metres_from_units_ * world->second;
    return world->second;
  }

  // Where a node's mesh stands: at the node or, by EXT_mesh_gpu_instancing, wherever its attributes say.
  std::vector<glm::dmat4> instancesOf(const tinygltf::Node& node, const glm::dmat4& world_from_local, const std::string& place) {
    const tinygltf::Value* attributes = memberOf(node.extensions, "EXT_mesh_gpu_instancing", "attributes");
    if (attributes == nullptr) return {world_from_local};
    constexpr std::array<const char*, 3> kKeys = {"TRANSLATION", "ROTATION", "SCALE"};
    std::array<std::vector<float>, 3> numbers;
    std::optional<size_t> count;
    for (size_t k = 0; k < kKeys.size(); ++k) {
      if (!attributes->Has(kKeys[k])) continue;
      const std::string of_key = place + ": " + kKeys[k];
      const int accessor = attributes->Get(kKeys[k]).IsInt() ? attributes->Get(kKeys[k]).Get<int>() : -1;
      requireIndex(accessor, model_.accessors.size(), path_, of_key, "an accessor");
      count = count.value_or(model_.accessors[static_cast<size_t>(accessor)].count);
      numbers[k] = readNumbers(model_, accessor, k == 1 ? 4 : 3, k == 1 ? 4 : 3, nullptr, *count, path_, of_key, budgets_);
    }
    std::vector<glm::dmat4> places;
    for (size_t i = 0; i < count.value_or(0); ++i) {
      tinygltf::Node instance;
      const std::array<std::vector<double>*, 3> members = {&instance.translation, &instance.rotation, &instance.scale};
      for (size_t k = 0; k < members.size(); ++k) {
        const size_t width = k == 1 ? 4 : 3;
        if (!numbers[k].empty()) members[k]->assign(&numbers[k][width * i], &numbers[k][width * i] + width);
      }
      places.push_back(world_from_local * localTransform(instance, place));
    }
    return places;
  }

  void addInstance(const GltfMesh& mesh, const std::string& name, const glm::dmat4& world_from_local, const std::string& place) {
    triangles_left_.take(mesh.triangles.size(), path_, place);
    if (mesh.triangles.empty()) return;
    for (const glm::vec3& p : mesh.positions) checkPosition(worldFrom(world_from_local, p), place);
    scene_.objects.push_back(
        {name, static_cast<uint32_t>(scene_.triangles.size()), static_cast<uint32_t>(mesh.triangles.size()), true});
    const auto base = static_cast<uint32_t>(world_positions_.size());
    for (const glm::vec3& p : mesh.positions) world_positions_.push_back(worldFrom(world_from_local, p));
    addLooks(mesh);
    const bool is_mirrored = (glm::determinant(glm::dmat3(world_from_local)) < 0.0) != mesh.is_mirrored;
    for (glm::uvec3 triangle : mesh.triangles) {
      if (is_mirrored) std::swap(triangle.y, triangle.z);
      scene_.triangles.push_back(triangle + base);
    }
    scene_.triangle_material.insert(scene_.triangle_material.end(), mesh.triangle_material.begin(), mesh.triangle_material.end());
  }

  static glm::dvec3 worldFrom(const glm::dmat4& world_from_local, const glm::vec3& p) {
    return glm::dvec3(world_from_local * glm::dvec4(glm::dvec3(p), 1.0));
  }

  GltfMesh readMesh(int mesh_idx, const GltfPose& pose) {
    GltfMesh mesh = readGltfMesh(model_, mesh_idx, looks_, pose, path_, budgets_, &odd_);
    unplaced_count_ += mesh.unplaced_count;
    return mesh;
  }

  // In the pose that the mesh itself has.
  const GltfMesh& localMesh(int mesh_idx) {
    if (!meshes_[mesh_idx]) meshes_[mesh_idx] = readMesh(mesh_idx, {model_.meshes[mesh_idx].weights, {}});
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
    append(judgeTransmissive(scene_, looks_.names, dense_transmissive_));
    append(odd_.notes());
    append(unreadParts(model_, std::set<int>(scene_.triangle_material.begin(), scene_.triangle_material.end())));
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
  const double dense_transmissive_;
  Oddities odd_;
  SceneBudgets budgets_;                                   // of the file: each mesh once
  SceneBudget triangles_left_ = SceneBudgets().triangles;  // of the scene: each instance
  const tinygltf::Model model_;
  const std::vector<int> parents_;  // by node
  const int scene_idx_;
  const std::vector<int> roots_;
  std::map<std::string, NodeHoldings> left_out_;  // by why
  std::vector<std::string> notes_;
  const std::vector<NodeVerdict> verdicts_;  // by node
  GltfLooks looks_;
  const glm::dmat4 metres_from_units_;
  std::map<int, glm::dmat4> worlds_;  // of joints
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

GltfLevel readGltf(const std::string& path, double unit_m, double dense_transmissive, const GltfChoice& choice, ImageNeed need) {
  return GltfConverter(path, unit_m, dense_transmissive, choice, need).convert();
}

}  // namespace nlg
