// Levels and archives of a few bytes, for tests that know what must come out.
#pragma once

#include <zip.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "tests/temporary_folder.h"

namespace nlg {

inline constexpr double kUnit = 0.0254;  // metres

// An .bsp file's parts, in the file's own terms: units, z up, polygons clockwise.
struct BspParts {
  struct Shader {
    std::string name;  // may hold a NUL and garbage behind it
    uint32_t surface_flags = 0, content_flags = 0;
  };
  struct Face {
    uint32_t shader = 0, kind = 1, first_vertex = 0, vertex_count = 0, first_index = 0, index_count = 0, width = 0, height = 0;
    int32_t lightmap = -3;  // by vertex
  };
  struct Model {
    uint32_t first_face = 0, face_count = 0;
    glm::vec3 min{0.0f}, max{0.0f};
  };
  struct Light {
    glm::vec2 place{0.0f};  // on the lightmap
    uint8_t colour[4] = {0, 0, 0, 0};
  };
  std::string entities = "{ \"classname\" \"worldspawn\" }";
  std::vector<Shader> shaders;
  std::vector<Model> models;
  std::vector<glm::vec3> vertices;
  std::vector<glm::vec2> texture_places;  // of the first vertices; those behind have (0, 0)
  std::vector<Light> lights;              // of the first vertices; those behind have none
  std::vector<uint32_t> indices;
  std::vector<Face> faces;
  std::string lightmaps, light_grid;  // lumps as they are

  // A polygon or mesh (kind 1, 3) of one quad, corners clockwise from its front; a patch (kind 2) of 3 x 3 points.
  void addFace(uint32_t shader, uint32_t kind, const std::vector<glm::vec3>& corners) {
    Face face{shader, kind, static_cast<uint32_t>(vertices.size()), static_cast<uint32_t>(corners.size()), 0, 0, 0, 0};
    if (kind == 2) {
      face.width = face.height = 3;
    } else {
      face.first_index = static_cast<uint32_t>(indices.size());
      face.index_count = 6;
      for (const uint32_t i : {0, 1, 2, 0, 2, 3}) indices.push_back(i);
    }
    vertices.insert(vertices.end(), corners.begin(), corners.end());
    faces.push_back(face);
    models.back().face_count = static_cast<uint32_t>(faces.size()) - models.back().first_face;
  }

  void beginModel() { models.push_back({static_cast<uint32_t>(faces.size()), 0, {}, {}}); }

  // What the compiler left at a vertex; those before it that had nothing have black.
  void lightVertex(size_t vertex, const glm::vec2& place, uint8_t red, uint8_t green, uint8_t blue) {
    if (lights.size() <= vertex) lights.resize(vertex + 1);
    lights[vertex] = {place, {red, green, blue, 255}};
  }

  // A page whose texel (x, y) is (x, y, 7).
  void addLightmap() {
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) lightmaps += {static_cast<char>(x), static_cast<char>(y), 7};
    }
  }

  std::string bytes() const {
    std::string lumps[17];
    lumps[0] = entities;
    for (const Shader& shader : shaders) {
      std::string name = shader.name;
      name.resize(64, '\0');
      lumps[1] += name + words({shader.surface_flags, shader.content_flags});
    }
    for (const Model& model : models) {
      lumps[7].append(reinterpret_cast<const char*>(&model.min), 12);
      lumps[7].append(reinterpret_cast<const char*>(&model.max), 12);
      lumps[7] += words({model.first_face, model.face_count, 0, 0});
    }
    for (size_t i = 0; i < vertices.size(); ++i) {
      const Light light = i < lights.size() ? lights[i] : Light{};
      lumps[10].append(reinterpret_cast<const char*>(&vertices[i]), 12);
      const glm::vec2 place = i < texture_places.size() ? texture_places[i] : glm::vec2(0.0f);
      lumps[10].append(reinterpret_cast<const char*>(&place), 8);
      lumps[10].append(reinterpret_cast<const char*>(&light.place), 8);
      lumps[10] += std::string(12, '\0');
      lumps[10].append(reinterpret_cast<const char*>(light.colour), 4);
    }
    lumps[11] = words(indices);
    for (const Face& face : faces) {
      lumps[13] +=
          words({face.shader, ~0u, face.kind, face.first_vertex, face.vertex_count, face.first_index, face.index_count}) +
          words({static_cast<uint32_t>(face.lightmap)}) + std::string(64, '\0') + words({face.width, face.height});
    }
    lumps[14] = lightmaps;
    lumps[15] = light_grid;
    std::string header = "IBSP" + words({46});
    std::string body;
    for (const std::string& lump : lumps) {
      header += words({static_cast<uint32_t>(144 + body.size()), static_cast<uint32_t>(lump.size())});
      body += lump;
    }
    return header + body;
  }

  static std::string words(const std::vector<uint32_t>& values) {
    return std::string(reinterpret_cast<const char*>(values.data()), 4 * values.size());
  }
};

// A floor of 100 x 100 units at z = 0, front up, and a quarter pipe along y whose inside looks up and to the left; shader 0.
inline BspParts smallLevel() {
  BspParts parts;
  parts.shaders.push_back({"textures/test/stone"});
  parts.beginModel();
  parts.addFace(0, 1, {{0, 0, 0}, {0, 100, 0}, {100, 100, 0}, {100, 0, 0}});
  std::vector<glm::vec3> pipe;
  for (const float y : {0.0f, 50.0f, 100.0f}) {
    for (const glm::vec3& p : {glm::vec3(100, 0, 0), glm::vec3(200, 0, 0), glm::vec3(200, 0, 100)}) pipe.push_back({p.x, y, p.z});
  }
  parts.addFace(0, 2, pipe);
  return parts;
}

struct ZipOptions {
  bool encrypted = false;
  int method = ZIP_CM_DEFLATE;
};

// Writes an archive through libzip; names as they are given.
inline std::string writeZip(const std::string& path, const std::vector<std::pair<std::string, std::string>>& files,
                            const ZipOptions& options = {}) {
  int code = 0;
  zip_t* zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  if (zip == nullptr) throw std::runtime_error("zip_open");
  for (const auto& [name, bytes] : files) {
    if (name.back() == '/') {
      if (zip_dir_add(zip, name.c_str(), 0) < 0) throw std::runtime_error("zip_dir_add");
      continue;
    }
    const zip_int64_t idx = zip_file_add(zip, name.c_str(), zip_source_buffer(zip, bytes.data(), bytes.size(), 0), 0);
    if (idx < 0) throw std::runtime_error("zip_file_add");
    zip_set_file_compression(zip, idx, options.method, 0);
    if (options.encrypted && zip_file_set_encryption(zip, idx, ZIP_EM_AES_128, "secret") != 0)
      throw std::runtime_error("encryption");
  }
  if (zip_close(zip) != 0) throw std::runtime_error("zip_close");
  return path;
}

inline std::string fileBytes(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace nlg
