// The records of a Quake III level (IBSP version 46) that hold geometry and light, read from bytes and checked.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

// Of a level, in its units; the game's own tools stop at 131072.
inline constexpr float kFarthestUnits = 1048576.0f;

struct BspShader {
  std::string name;                               // as written, up to the first NUL: what follows it is garbage
  uint32_t surface_flags = 0, content_flags = 0;  // as the game's compiler stored them: bsp_shader.cpp
};

enum class BspFaceKind : uint32_t { polygon = 1, patch = 2, mesh = 3, flare = 4 };

// Polygons and meshes: triangles of index_count / 3, indices relative to first_vertex, front faces clockwise.
// Patches: patch_width x patch_height control points, row by row, both odd and from 3 to 65.
struct BspFace {
  uint32_t shader = 0;
  BspFaceKind kind = BspFaceKind::polygon;
  uint32_t first_vertex = 0, vertex_count = 0;
  uint32_t first_index = 0, index_count = 0;
  uint32_t patch_width = 0, patch_height = 0;
  int32_t lightmap = -1;  // its page; negative or not below lightmap_count: of a file, or light by vertex, as the engine has it
};

using BspColour = std::array<uint8_t, 3>;  // red, green, blue

// What the level's compiler computed for a vertex.
struct BspVertexLight {
  glm::vec2 lightmap_place{0.0f};  // on the face's page, x along a row; finite where a face with a page names it
  BspColour colour{};
};

inline constexpr uint32_t kBspLightmapSide = 128;  // texels

// Model 0 is the level itself; the others are doors, platforms and the like. Models share no face.
struct BspModel {
  uint32_t first_face = 0, face_count = 0;
  glm::vec3 min{0.0f}, max{0.0f};  // in the game's units; as written, of model 0 finite
};

struct BspFile {
  std::string entities;  // text
  std::vector<BspShader> shaders;
  std::vector<BspModel> models;      // at least one
  std::vector<glm::vec3> positions;  // in the game's units, z up; finite, within 2^20 of the origin
  std::vector<glm::vec2>
      texture_places;  // one for each position, as they lie on the texture: (0, 0) its upper left corner; finite
  std::vector<BspVertexLight> vertex_light;  // one for each position
  std::vector<uint32_t> indices;
  std::vector<BspFace> faces;
  std::vector<BspColour> lightmap_texels;  // all pages, kBspLightmapSide² each, rows from the top; empty when the level has none
  uint32_t lightmap_count = 0;             // pages
};

// path     only named in errors
// bytes    the whole file
// throws   InputError with lump and record on
//          - another magic or version, a lump that leaves the file, is no whole number of records or has more than any level
//          - an index or range out of bounds, a face of an unknown kind, models that share faces
//          - numbers that are not finite or too large, lightmap places that are not finite
//          - faces that name more than 2^23 vertices, or 3 * 2^23 indices, together
BspFile parseBsp(const std::string& path, std::string_view bytes);

}  // namespace nlg
