// What stands where in the JSON of a glTF file: the kinds of the values that the reader depends on.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace nlg {

enum class JsonKind { null, boolean, index, integer, number, string, array, object };

inline const char* kindName(JsonKind kind) {
  constexpr std::array<const char*, 8> kNames = {"null", "boolean", "index", "integer", "number", "string", "array", "object"};
  return kNames[static_cast<size_t>(kind)];
}

// What a property must be when it is there. index: below 2^31, as tinygltf keeps it; integer: below 2^53.
struct GltfRule {
  std::string_view section, key;
  JsonKind kind;
};

inline constexpr std::array<GltfRule, 35> kRules = {{{"buffers", "uri", JsonKind::string},
                                                     {"buffers", "byteLength", JsonKind::integer},
                                                     {"bufferViews", "buffer", JsonKind::index},
                                                     {"bufferViews", "byteOffset", JsonKind::integer},
                                                     {"bufferViews", "byteLength", JsonKind::integer},
                                                     {"bufferViews", "byteStride", JsonKind::index},
                                                     {"bufferViews", "count", JsonKind::index},
                                                     {"bufferViews", "mode", JsonKind::string},
                                                     {"bufferViews", "filter", JsonKind::string},
                                                     {"buffers", "fallback", JsonKind::boolean},
                                                     {"accessors", "bufferView", JsonKind::index},
                                                     {"accessors", "byteOffset", JsonKind::integer},
                                                     {"accessors", "componentType", JsonKind::index},
                                                     {"accessors", "count", JsonKind::integer},
                                                     {"accessors", "normalized", JsonKind::boolean},
                                                     {"accessors", "sparse", JsonKind::object},
                                                     {"meshes", "bufferView", JsonKind::index},
                                                     {"meshes", "primitives", JsonKind::array},
                                                     {"meshes", "attributes", JsonKind::object},
                                                     {"meshes", "POSITION", JsonKind::index},
                                                     {"meshes", "indices", JsonKind::index},
                                                     {"meshes", "material", JsonKind::index},
                                                     {"meshes", "mode", JsonKind::index},
                                                     {"nodes", "mesh", JsonKind::index},
                                                     {"nodes", "children", JsonKind::array},
                                                     {"nodes", "translation", JsonKind::array},
                                                     {"nodes", "rotation", JsonKind::array},
                                                     {"nodes", "scale", JsonKind::array},
                                                     {"nodes", "matrix", JsonKind::array},
                                                     {"scenes", "nodes", JsonKind::array},
                                                     {"materials", "pbrMetallicRoughness", JsonKind::object},
                                                     {"materials", "baseColorFactor", JsonKind::array},
                                                     {"materials", "emissiveFactor", JsonKind::array},
                                                     {"materials", "doubleSided", JsonKind::boolean},
                                                     {"materials", "emissiveStrength", JsonKind::number}}};

// How many numbers an array holds; tinygltf ignores those of another length.
struct GltfLengthRule {
  std::string_view section, key;
  size_t length;
};

inline constexpr std::array<GltfLengthRule, 6> kLengths = {{{"nodes", "translation", 3},
                                                            {"nodes", "rotation", 4},
                                                            {"nodes", "scale", 3},
                                                            {"nodes", "matrix", 16},
                                                            {"materials", "baseColorFactor", 4},
                                                            {"materials", "emissiveFactor", 3}}};

inline constexpr std::array<std::string_view, 8> kSections = {"buffers", "bufferViews", "accessors", "meshes",
                                                              "nodes",   "scenes",      "materials", "images"};

inline bool isSection(std::string_view key) {
  for (const std::string_view section : kSections) {
    if (section == key) return true;
  }
  return false;
}

// Extensions that a file may require: those that the reader follows, and those about looks, which can be missing. Any other may
// change where triangles are.
inline constexpr std::array<std::string_view, 3> kReadExtensions = {"KHR_mesh_quantization", "EXT_meshopt_compression",
                                                                    "KHR_draco_mesh_compression"};
inline constexpr std::array<std::string_view, 4> kLookExtensions = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                                                    "KHR_lights_"};  // beginnings of names

// Extensions whose members the rules hold for, too; whatever else stands in an extension is anybody's.
inline constexpr std::array<std::string_view, 3> kCheckedExtensions = {"KHR_materials_emissive_strength",
                                                                       "KHR_draco_mesh_compression", "EXT_meshopt_compression"};

inline bool isChecked(std::string_view extension) {
  for (const std::string_view name : kCheckedExtensions) {
    if (extension == name) return true;
  }
  return false;
}

inline bool mayBeRequired(std::string_view extension) {
  for (const std::string_view name : kReadExtensions) {
    if (extension == name) return true;
  }
  for (const std::string_view start : kLookExtensions) {
    if (extension.substr(0, start.size()) == start) return true;
  }
  return false;
}

inline bool satisfies(JsonKind got, JsonKind expected) {
  if (expected == JsonKind::integer) return got == JsonKind::integer || got == JsonKind::index;
  if (expected == JsonKind::number) return got == JsonKind::number || got == JsonKind::integer || got == JsonKind::index;
  return got == expected;
}

}  // namespace nlg
