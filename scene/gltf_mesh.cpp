#include "scene/gltf_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "scene/gltf_accessor.h"
#include "tool/error.h"

namespace nlg {
namespace {

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

// What KHR_mesh_quantization lets positions be beside floats.
bool isSmallInteger(int component_type) {
  return component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component_type == TINYGLTF_COMPONENT_TYPE_SHORT || component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
}

// One component of an attribute; normalized integers by glTF's formulas: the largest is 1, the smallest signed one no less than -1.
float componentAt(const unsigned char* bytes, int component_type, bool is_normalized) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_FLOAT) {
    float value = 0.0f;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  const bool is_byte = component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
  const int byte_count = is_byte ? 1 : 2;
  const bool is_signed = component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_SHORT;
  const int range = 1 << (8 * byte_count);
  int value = static_cast<int>(readUnsigned(bytes, byte_count));
  if (is_signed && value >= range / 2) value -= range;
  if (!is_normalized) return static_cast<float>(value);
  return std::max(static_cast<float>(value) / static_cast<float>(is_signed ? range / 2 - 1 : range - 1), -1.0f);
}

class MeshReader {
 public:
  MeshReader(const tinygltf::Model& model, const GltfLooks& looks, const std::string& path, SceneBudgets& budgets)
      : model_(model), looks_(looks), path_(path), budgets_(budgets) {
    const std::vector<std::string>& used = model.extensionsUsed;
    is_quantized_ = std::find(used.begin(), used.end(), "KHR_mesh_quantization") != used.end();
  }

  GltfMesh read(int mesh_idx) {
    GltfMesh mesh;
    const std::vector<tinygltf::Primitive>& primitives = model_.meshes[mesh_idx].primitives;
    for (size_t i = 0; i < primitives.size(); ++i) {
      addPrimitive(primitives[i], "mesh " + std::to_string(mesh_idx) + ", primitive " + std::to_string(i), mesh);
    }
    return mesh;
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const std::string& place, GltfMesh& local) {
    const int mode = primitive.mode;
    if (mode < 0 || mode > TINYGLTF_MODE_TRIANGLE_FAN) fail(place + ": mode", "0 to 6", std::to_string(mode));
    if (!isTriangleMode(mode)) return;
    const AccessorReader positions = positionReader(primitive, place);
    const tinygltf::Accessor& accessor = model_.accessors[primitive.attributes.at("POSITION")];
    const std::vector<uint32_t> corners = readCorners(primitive, positions.count(), place);
    const uint32_t material = materialOf(primitive, place);

    std::vector<uint32_t> used = corners;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto base = static_cast<uint32_t>(local.positions.size());
    for (const uint32_t idx : used) local.positions.push_back(readPosition(positions, accessor, idx));
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
    const bool is_there = readAttribute(
        primitive, place, "TEXCOORD_" + std::to_string(placing.set), 2, 2, used, vertex_count, [&](size_t i, const float* uv) {
          const glm::dvec2 on_image = placing.from_mesh * glm::dvec3(uv[0], uv[1], 1.0);
          const bool is_number = std::isfinite(on_image.x) && std::isfinite(on_image.y);
          is_placed = is_placed && is_number;
          if (is_number) places[first + i] = glm::vec2(glm::clamp(on_image, glm::dvec2(-1e9), glm::dvec2(1e9)));
        });
    return is_there && is_placed;
  }

  void readColours(const tinygltf::Primitive& primitive, const std::string& place, const std::vector<uint32_t>& used,
                   uint64_t vertex_count, const GltfLooks::OfVertices& look, GltfMesh& local) {
    std::vector<glm::vec4> colours(used.size(), glm::vec4(1.0f));
    const bool is_there = readAttribute(primitive, place, "COLOR_0", 3, 4, used, vertex_count, [&](size_t i, const float* rgba) {
      for (int channel = 0; channel < 4; ++channel) {
        // what is no number stays white
        if (std::isfinite(rgba[channel])) colours[i][channel] = std::clamp(rgba[channel], 0.0f, 1.0f);
      }
      if (!look.keeps_opacity) colours[i].a = 1.0f;
      if (look.least_opacity > 0.0f) colours[i].a = colours[i].a >= look.least_opacity ? 1.0f : 0.0f;
    });
    if (!is_there && local.colours.empty()) return;
    local.colours.resize(local.positions.size() - used.size(), glm::vec4(1.0f));
    local.colours.insert(local.colours.end(), colours.begin(), colours.end());
  }

  // Calls take(i, numbers) for each vertex that is used; numbers that an element lacks are 1.
  // returns   false where the primitive has no such attribute
  template <class Take>
  bool readAttribute(const tinygltf::Primitive& primitive, const std::string& primitive_place, const std::string& name,
                     int least_components, int most_components, const std::vector<uint32_t>& used, uint64_t vertex_count,
                     const Take& take) {
    const auto attribute = primitive.attributes.find(name);
    if (attribute == primitive.attributes.end()) return false;
    const std::string place = primitive_place + ": " + name;
    requireIndex(attribute->second, model_.accessors.size(), path_, place, "an accessor");
    const tinygltf::Accessor& accessor = model_.accessors[static_cast<size_t>(attribute->second)];
    const int type = accessor.componentType;
    const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    const bool is_known = type == TINYGLTF_COMPONENT_TYPE_FLOAT || isSmallInteger(type);
    if (!is_known || components < least_components || components > most_components)
      fail(place,
           "FLOAT or integers of 8 or 16 bits, VEC" + std::to_string(least_components) + " to VEC" +
               std::to_string(most_components),
           "component type " + std::to_string(type) + ", type " + std::to_string(accessor.type));
    const AccessorReader elements(model_, attribute->second, path_, place, budgets_);
    if (elements.count() < vertex_count)
      fail(place, std::to_string(vertex_count) + " elements", std::to_string(elements.count()));
    budgets_.accessor_elements.take(used.size(), path_, place);
    const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type));
    for (size_t i = 0; i < used.size(); ++i) {
      std::array<float, 4> numbers{1.0f, 1.0f, 1.0f, 1.0f};
      const unsigned char* bytes = elements.element(used[i]);
      for (int k = 0; k < components; ++k)
        numbers[static_cast<size_t>(k)] =
            bytes == nullptr ? 0.0f : componentAt(bytes + k * component_bytes, type, accessor.normalized);
      take(i, numbers.data());
    }
    return true;
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
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES && count % 3 != 0)
      fail(place, "a multiple of 3 corners", std::to_string(count));
    std::vector<uint32_t> corners(count);
    const int byte_count =
        is_indexed ? tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(model_.accessors[primitive.indices].componentType))
                   : 0;
    for (uint64_t i = 0; i < count; ++i) {
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
      if (!std::isfinite(p[axis])) fail(place_, "finite numbers", std::to_string(p[axis]) + " at vertex " + std::to_string(idx));
    }
    return p;
  }

  const tinygltf::Model& model_;
  const GltfLooks& looks_;
  const std::string& path_;
  SceneBudgets& budgets_;
  bool is_quantized_ = false;
  std::string place_;  // of the positions being read
};

}  // namespace

GltfMesh readGltfMesh(const tinygltf::Model& model, int mesh_idx, const GltfLooks& looks, const std::string& path,
                      SceneBudgets& budgets) {
  return MeshReader(model, looks, path, budgets).read(mesh_idx);
}

}  // namespace nlg
