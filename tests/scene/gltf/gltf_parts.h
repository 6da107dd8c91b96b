// Small glTF files made piece by piece, for tests that then spoil a piece.
#pragma once

#include "scene/gltf/gltf_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>

#include "tests/input_error.h"
#include "tests/scene/scene_triangles.h"
#include "tests/temporary_folder.h"

namespace nlg {

namespace fs = std::filesystem;

inline std::string base64(const std::string& bytes) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kLetters[group >> (18 - 6 * k) & 63];
  }
  return text;
}

template <class T>
std::string bytesOf(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the test's text has no " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A unit square in the plane z = 0, front towards +z: four positions, then the indices 0 1 2 0 2 3 as 16 bits.
inline const std::string kSquare = bytesOf<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) + bytesOf<uint16_t>({0, 1, 2, 0, 2, 3});

// A .glb of these two chunks.
inline std::string glbOf(std::string json, std::string payload) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  payload.resize((payload.size() + 3) / 4 * 4, '\0');
  const auto word = [](size_t value) { return bytesOf<uint32_t>({static_cast<uint32_t>(value)}); };
  return "glTF" + word(2) + word(28 + json.size() + payload.size()) + word(json.size()) + "JSON" + json + word(payload.size()) +
         std::string("BIN\0", 4) + payload;
}

// The parts of a file with one mesh; tests replace one of them.
struct Parts {
  std::string bin = kSquare;
  std::string views = R"([{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}])";
  std::string accessors =
      R"([{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}])";
  std::string primitives = R"([{"attributes":{"POSITION":0},"indices":1}])";
  std::string nodes = R"([{"mesh":0,"name":"square"}])";
  std::string scenes = R"([{"nodes":[0]}])";
  std::string more_buffers;  // further buffers, each led by a comma
  std::string more;          // further members of the root, each led by a comma

  // Appends bytes in a view of their own, and an accessor of them where it is described.
  void add(const std::string& bytes, const std::string& accessor = "") {
    views.back() = ',';
    views +=
        R"({"buffer":0,"byteOffset":)" + std::to_string(bin.size()) + R"(,"byteLength":)" + std::to_string(bytes.size()) + "}]";
    bin += bytes;
    if (accessor.empty()) return;
    accessors.back() = ',';
    accessors += R"({"bufferView":)" + std::to_string(std::count(views.begin(), views.end(), '{') - 1) + "," + accessor + "}]";
  }

  std::string json(const std::string& uri) const {
    const std::string uri_member = uri.empty() ? "" : R"(,"uri":")" + uri + "\"";
    return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" + std::to_string(bin.size()) + uri_member + "}" +
           more_buffers + R"(],"bufferViews":)" + views + R"(,"accessors":)" + accessors + R"(,"meshes":[{"primitives":)" +
           primitives + R"(}],"nodes":)" + nodes + R"(,"scenes":)" + scenes + more + "}";
  }
  std::string text() const { return json("data:application/octet-stream;base64," + base64(bin)); }
  std::string binary() const { return glbOf(json(""), bin); }
};

class GltfFiles : public testing::Test {
 protected:
  GltfFiles() { fs::create_directory(folder_ / "level"); }

  std::string write(const std::string& name, const std::string& bytes) const { return folder_.write("level/" + name, bytes); }
  Scene read(const Parts& parts) const { return readGltf(write("test.gltf", parts.text())).scene; }

  // The line of the InputError that reading the bytes gives.
  std::string errorOf(const std::string& bytes) const {
    return inputErrorOf([&] { readGltf(write("hostile.gltf", bytes)); });
  }

  // The same, or where the file is read the notes, behind its name.
  std::string saidOf(const std::string& bytes) const {
    std::string said = "hostile.gltf: ";
    const std::string error = inputErrorOf([&] {
      for (const std::string& note : readGltf(write("hostile.gltf", bytes)).notes) said += note + "; ";
    });
    return error == "no error" ? said : error;
  }

  TemporaryFolder folder_;
};

inline double areaOf(const Scene& scene) {
  double area = 0.0;
  for (size_t i = 0; i < scene.triangles.size(); ++i) area += 0.5 * glm::length(normalOf(scene, i));
  return area;
}

}  // namespace nlg
