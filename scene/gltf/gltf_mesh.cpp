#include "scene/gltf/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "scene/gltf/gltf_accessor.h"
#include "scene/model/vertex_colours.h"
#include "tool/error.h"

namespace nlg {
namespace {

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

class MeshReader {
 public:
  MeshReader(const tinygltf::Model& model, const GltfLooks& looks, const GltfPose& pose, const std::string& path,
             SceneBudgets& budgets, Oddities* odd)
      : model_(model), looks_(looks), pose_(pose), path_(path), budgets_(budgets), odd_(*odd) {
    const std::vector<std::string>& used = model.extensionsUsed;
    is_quantized_ = std::find(used.begin(), used.end(), "KHR_mesh_quantization") != used.end();
  }

  GltfMesh read(int mesh_idx) {
    GltfMesh mesh;
    mesh.is_mirrored = !pose_.joints.empty() && glm::determinant(glm::dmat3(pose_.joints[0])) < 0.0;
    const std::vector<tinygltf::Primitive>& primitives = model_.meshes[mesh_idx].primitives;
    for (size_t i = 0; i < primitives.size(); ++i) {
      const std::string place = "mesh " + std::to_string(mesh_idx) + ", primitive " + std::to_string(i);
      const size_t vertex_count = mesh.positions.size();
      if (odd_.attempt("left out", [&] { addPrimitive(primitives[i], place, mesh); })) continue;
      mesh.positions.resize(vertex_count);
      for (auto* places : {&mesh.base_places, &mesh.emissive_places}) places->resize(std::min(places->size(), vertex_count));
      mesh.colours.resize(std::min(mesh.colours.size(), vertex_count));
    }
    return mesh;
  }

 private:
  using Attributes = std::map<std::string, int>;

  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const std::string& place, GltfMesh& local) {
    const int mode = primitive.mode;
    if (mode < 0 || mode > TINYGLTF_MODE_TRIANGLE_FAN) fail(place + ": mode", "0 to 6", std::to_string(mode));
    if (mode < TINYGLTF_MODE_TRIANGLES) return;
    const AccessorReader positions = positionReader(primitive, place);
    const tinygltf::Accessor& accessor = model_.accessors[primitive.attributes.at("POSITION")];
    const std::vector<uint32_t> corners = readCorners(primitive, positions.count(), place);
    const uint32_t material = materialOf(primitive, place);

    std::vector<uint32_t> used = corners;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto base = static_cast<uint32_t>(local.positions.size());
    for (const uint32_t idx : used) local.positions.push_back(readPosition(positions, accessor, idx));
    morph(primitive, place, used, positions.count(), local.positions.data() + base);
    if (!pose_.joints.empty()) bend(primitive, place, used, positions.count(), local.positions.data() + base);
    readLooks(primitive, place, used, positions.count(), looks_.of_vertices[material], local);
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

  // Adds what the morph targets move the vertices by.
  void morph(const tinygltf::Primitive& primitive, const std::string& place, const std::vector<uint32_t>& used,
             uint64_t vertex_count, glm::vec3* positions) {
    for (size_t t = 0; t < std::min(primitive.targets.size(), pose_.weights.size()); ++t) {
      const auto weight = static_cast<float>(pose_.weights[t]);
      if (weight == 0.0f) continue;
      const std::vector<float> by =
          readAttribute(primitive.targets[t], place + ", target " + std::to_string(t), "POSITION", 3, 3, used, vertex_count);
      for (size_t i = 0; i < by.size() / 3; ++i) positions[i] += weight * glm::vec3(by[3 * i], by[3 * i + 1], by[3 * i + 2]);
    }
  }

  // Moves the vertices by their joints, up to eight of them and more.
  void bend(const tinygltf::Primitive& primitive, const std::string& place, const std::vector<uint32_t>& used,
            uint64_t vertex_count, glm::vec3* positions) {
    std::vector<glm::dvec4> moved(used.size(), glm::dvec4(0.0));
    for (int set = 0; set == 0 || primitive.attributes.count("JOINTS_" + std::to_string(set)) > 0; ++set) {
      const std::string n = std::to_string(set);
      const std::vector<float> joints = readAttribute(primitive.attributes, place, "JOINTS_" + n, 4, 4, used, vertex_count),
                               weights = readAttribute(primitive.attributes, place, "WEIGHTS_" + n, 4, 4, used, vertex_count);
      if (joints.empty() || weights.empty()) fail(place, "JOINTS_" + n + " and WEIGHTS_" + n + " of a mesh with a skin", "none");
      for (size_t i = 0; i < joints.size(); ++i) {
        if (weights[i] == 0.0f) continue;
        const auto joint = static_cast<size_t>(std::max(joints[i], 0.0f));
        if (joint >= pose_.joints.size())
          fail(place + ": JOINTS_" + n, "joints below " + std::to_string(pose_.joints.size()), std::to_string(joint));
        moved[i / 4] += static_cast<double>(weights[i]) * (pose_.joints[joint] * glm::dvec4(glm::dvec3(positions[i / 4]), 1.0));
      }
    }
    for (size_t i = 0; i < used.size(); ++i) {
      // what hangs on no joint hangs on the first; otherwise weights add up to 1, up to rounding
      if (moved[i].w == 0.0) moved[i] = pose_.joints[0] * glm::dvec4(glm::dvec3(positions[i]), 1.0);
      positions[i] = glm::vec3(glm::dvec3(moved[i]) / moved[i].w);
      requireFinite(positions[i], place + ": WEIGHTS_0", used[i]);
    }
  }

  // What stands beside the positions of the vertices that are used.
  void readLooks(const tinygltf::Primitive& primitive, const std::string& place, const std::vector<uint32_t>& used,
                 uint64_t vertex_count, const GltfLooks::OfVertices& look, GltfMesh& local) {
    bool is_placed = true;
    if (looks_.has_base_places) is_placed = readPlaces(primitive, place, used, vertex_count, look.base, local.base_places);
    if (looks_.has_emissive_places)
      is_placed = readPlaces(primitive, place, used, vertex_count, look.emissive, local.emissive_places) && is_placed;
    if (!is_placed) ++local.unplaced_count;
    readColours(primitive, place, used, vertex_count, look, local);
  }

  // false where some are missing, or no numbers
  bool readPlaces(const tinygltf::Primitive& primitive, const std::string& place, const std::vector<uint32_t>& used,
                  uint64_t vertex_count, const GltfPlacing& placing, std::vector<glm::vec2>& places) {
    const size_t first = places.size();
    places.resize(first + used.size(), glm::vec2(0.0f));
    if (placing.set < 0) return true;
    bool is_placed = true;
    const std::vector<float> uv = readLook(primitive, place, "TEXCOORD_" + std::to_string(placing.set), 2, 2, used, vertex_count);
    for (size_t i = 0; i < uv.size() / 2; ++i) {
      const glm::dvec2 on_image = placing.from_mesh * glm::dvec3(uv[2 * i], uv[2 * i + 1], 1.0);
      const bool is_number = std::isfinite(on_image.x) && std::isfinite(on_image.y);
      is_placed = is_placed && is_number;
      if (is_number) places[first + i] = glm::vec2(glm::clamp(on_image, glm::dvec2(-1e9), glm::dvec2(1e9)));
    }
    return is_placed && !uv.empty();
  }

  // Shares of white: colours apart from alpha, which may be a share beside codes.
  // rgba   as read: alpha is 1 where there is none
  void makeColours(const tinygltf::Primitive& primitive, const std::string& place, std::vector<float>* rgba) {
    if (rgba->empty()) return;
    const tinygltf::Accessor& accessor = model_.accessors[static_cast<size_t>(primitive.attributes.at("COLOR_0"))];
    const bool is_short = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    const bool is_code = is_short || accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    float most_white = 1.0f;
    size_t cut_count = 0;
    std::vector<float> parts[2];  // of colours, of alpha
    for (size_t i = 0; i < rgba->size(); ++i) parts[i % 4 / 3].push_back((*rgba)[i]);
    for (std::vector<float>& part : parts) {
      if (&part == &parts[1] && accessor.type != TINYGLTF_TYPE_VEC4) continue;
      const float white = !is_code ? whiteOf(part) : accessor.normalized ? 1.0f : is_short ? 65535.0f : 255.0f;
      most_white = std::max(most_white, white);
      cut_count += makeShares(white, &part);
    }
    for (size_t i = 0; i < rgba->size(); ++i) (*rgba)[i] = parts[i % 4 / 3][i / 4 * (i % 4 == 3 ? 1 : 3) + i % 4 % 3];
    const std::string what = place + ": COLOR_0";
    if (most_white > 1.0f)
      odd_.add(fmt::format("taken as of 0 to {:g}", most_white), what + (is_code ? " of integers that are not normalized" : ""));
    if (cut_count > 0) odd_.add("cut", fmt::format("{}: {} numbers outside of 0 to {:g}", what, cut_count, most_white));
  }

  void readColours(const tinygltf::Primitive& primitive, const std::string& place, const std::vector<uint32_t>& used,
                   uint64_t vertex_count, const GltfLooks::OfVertices& look, GltfMesh& local) {
    std::vector<glm::vec4> colours(used.size(), glm::vec4(1.0f));
    std::vector<float> rgba = readLook(primitive, place, "COLOR_0", 3, 4, used, vertex_count);
    makeColours(primitive, place, &rgba);
    for (size_t i = 0; i < rgba.size() / 4; ++i) {
      for (int channel = 0; channel < 4; ++channel) {
        // what is no number stays white
        const float share = rgba[4 * i + static_cast<size_t>(channel)];
        if (!std::isnan(share)) colours[i][channel] = share;
      }
      if (!look.keeps_opacity) colours[i].a = 1.0f;
      if (look.least_opacity > 0.0f) colours[i].a = colours[i].a >= look.least_opacity ? 1.0f : 0.0f;
    }
    if (rgba.empty() && local.colours.empty()) return;
    local.colours.resize(local.positions.size() - used.size(), glm::vec4(1.0f));
    local.colours.insert(local.colours.end(), colours.begin(), colours.end());
  }

  // Numbers of the vertices that are used, `width` each; none where there is no such attribute.
  std::vector<float> readAttribute(const Attributes& attributes, const std::string& place, const std::string& name, int least,
                                   int width, const std::vector<uint32_t>& used, uint64_t vertex_count) {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return {};
    return readNumbers(model_, found->second, least, width, &used, vertex_count, path_, place + ": " + name, budgets_);
  }

  // The same of what triangles can be without.
  std::vector<float> readLook(const tinygltf::Primitive& primitive, const std::string& place, const std::string& name, int least,
                              int width, const std::vector<uint32_t>& used, uint64_t vertex_count) {
    std::vector<float> numbers;
    odd_.attempt("as if there were none",
                 [&] { numbers = readAttribute(primitive.attributes, place, name, least, width, used, vertex_count); });
    return numbers;
  }

  AccessorReader positionReader(const tinygltf::Primitive& primitive, const std::string& place) {
    const auto attribute = primitive.attributes.find("POSITION");
    place_ = place + ": POSITION";
    if (attribute == primitive.attributes.end()) fail(place_, "FLOAT VEC3", "none");
    requireIndex(attribute->second, model_.accessors.size(), path_, place_, "an accessor");
    const tinygltf::Accessor& accessor = model_.accessors[attribute->second];
    const int type = accessor.componentType;
    const bool is_known = type == TINYGLTF_COMPONENT_TYPE_FLOAT || (is_quantized_ && isSmallInteger(type));
    if (!is_known || accessor.type != TINYGLTF_TYPE_VEC3) {
      fail(place_, is_quantized_ ? "VEC3 of FLOAT or integers of 8 or 16 bits" : "FLOAT VEC3",
           "component type " + std::to_string(accessor.componentType) + ", type " + std::to_string(accessor.type));
    }
    return AccessorReader(model_, attribute->second, path_, place_, budgets_);
  }

  // The primitive's list of vertices, all below vertex_count.
  std::vector<uint32_t> readCorners(const tinygltf::Primitive& primitive, uint64_t vertex_count, const std::string& place) {
    const bool is_indexed = primitive.indices >= 0;
    const std::string indices_place = place + ": indices";
    const std::optional<AccessorReader> indices =
        is_indexed ? std::optional(indexReader(primitive.indices, indices_place)) : std::nullopt;
    const uint64_t count = is_indexed ? indices->count() : vertex_count;
    budgets_.triangles.take(triangleCount(primitive.mode, count), path_, place);
    budgets_.accessor_elements.take(count, path_, is_indexed ? indices_place : place);
    const bool is_in_threes = primitive.mode != TINYGLTF_MODE_TRIANGLES || count % 3 == 0;
    if (!is_in_threes) odd_.add("the last ones left out", place + ": " + std::to_string(count) + " corners, no multiple of 3");
    std::vector<uint32_t> corners(is_in_threes ? count : count - count % 3);
    const int byte_count =
        is_indexed ? tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(model_.accessors[primitive.indices].componentType))
                   : 0;
    for (uint64_t i = 0; i < corners.size(); ++i) {
      const unsigned char* bytes = is_indexed ? indices->element(i) : nullptr;
      corners[i] = bytes != nullptr ? readUnsigned(bytes, byte_count) : is_indexed ? 0 : static_cast<uint32_t>(i);
      if (corners[i] < vertex_count) continue;
      fail(indices_place, "indices below " + std::to_string(vertex_count),
           std::to_string(corners[i]) + " at " + std::to_string(i));
    }
    return corners;
  }

  AccessorReader indexReader(int accessor_idx, const std::string& place) {
    requireIndex(accessor_idx, model_.accessors.size(), path_, place, "an accessor");
    const tinygltf::Accessor& accessor = model_.accessors[accessor_idx];
    const int type = accessor.componentType;
    const bool is_unsigned = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                             type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (!is_unsigned || accessor.type != TINYGLTF_TYPE_SCALAR) {
      fail(place, "unsigned SCALAR of 8, 16 or 32 bits",
           "component type " + std::to_string(type) + ", type " + std::to_string(accessor.type));
    }
    return AccessorReader(model_, accessor_idx, path_, place, budgets_);
  }

  uint32_t materialOf(const tinygltf::Primitive& primitive, const std::string& place) const {
    if (primitive.material < 0) return static_cast<uint32_t>(model_.materials.size());
    requireIndex(primitive.material, model_.materials.size(), path_, place + ": material", "a material");
    return static_cast<uint32_t>(primitive.material);
  }

  glm::vec3 readPosition(const AccessorReader& positions, const tinygltf::Accessor& accessor, uint32_t idx) const {
    glm::vec3 p(0.0f);
    const unsigned char* bytes = positions.element(idx);
    const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
    for (int axis = 0; axis < 3 && bytes != nullptr; ++axis) {
      p[axis] = componentAt(bytes + axis * component_bytes, accessor.componentType, accessor.normalized);
    }
    requireFinite(p, place_, idx);
    return p;
  }

  void requireFinite(const glm::vec3& p, const std::string& place, uint32_t idx) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(p[axis])) fail(place, "finite numbers", std::to_string(p[axis]) + " at vertex " + std::to_string(idx));
    }
  }

  const tinygltf::Model& model_;
  const GltfLooks& looks_;
  const GltfPose& pose_;
  const std::string& path_;
  SceneBudgets& budgets_;
  Oddities& odd_;
  bool is_quantized_ = false;
  std::string place_;  // of the positions being read
};

}  // namespace

GltfMesh readGltfMesh(const tinygltf::Model& model, int mesh_idx, const GltfLooks& looks, const GltfPose& pose,
                      const std::string& path, SceneBudgets& budgets, Oddities* odd) {
  return MeshReader(model, looks, pose, path, budgets, odd).read(mesh_idx);
}

}  // namespace nlg
