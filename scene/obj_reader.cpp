#include "scene/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <unordered_map>
#include <utility>

#define TINYOBJLOADER_USE_DOUBLE  // as the library that is linked was built
#include <tiny_obj_loader.h>

#include "scene/obj_text.h"
#include "scene/scene_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kFarthest = 1e9;  // metres from the file's origin, as of glTF

std::string_view textOf(const std::vector<unsigned char>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string placeOf(const std::string& library) { return "mtllib \"" + library.substr(0, 80) + "\""; }

// Opens the material libraries that a file names: those in its folder or below.
// bytes_left   must outlive what is returned
ObjLibrary librariesBeside(const std::string& path, SceneBudget& bytes_left) {
  return [path, &bytes_left](const std::string& name) {
    ObjLibraryFile file;
    const bool is_beside = name.find_first_of("\\:") == std::string::npos && name[0] != '/';
    if (!is_beside) file.problem = "is a path of another place: not opened";
    std::error_code error;
    const bool is_missing =
        std::filesystem::status(folderOf(path) + "/" + name, error).type() == std::filesystem::file_type::not_found;
    if (is_beside && is_missing) file.problem = "is not there";
    if (!file.problem.empty()) return file;
    file.path = fileBeside(path, name, placeOf(name));
    // by whatever name it goes
    file.key = std::filesystem::weakly_canonical(file.path).string();
    file.read = [&bytes_left, library = file.path] { return std::string(textOf(readSceneFile(library, "file", bytes_left))); };
    return file;
  };
}

// Hands tinyobjloader the checked text of a library.
class LibraryReader : public tinyobj::MaterialReader {
 public:
  LibraryReader(const ObjLibrary& library, std::vector<std::string>* notes) : library_(library), notes_(notes) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials, std::map<std::string, int>* by_name,
                  std::string* warning, std::string* error) override {
    const ObjLibraryFile file = library_(name);
    if (!file.problem.empty()) {
      notes_->push_back(placeOf(name) + " " + file.problem);
      return false;
    }
    // its materials are there already
    if (!opened_.insert(file.key).second) return true;
    std::istringstream stream(checkedMtlText(file.path, file.read()));
    tinyobj::LoadMtl(by_name, materials, &stream, warning, error);
    return true;
  }

 private:
  const ObjLibrary& library_;
  std::vector<std::string>* notes_;
  std::set<std::string> opened_;  // by key
};

class ObjConverter {
 public:
  ObjConverter(const std::string& path, double unit_m) : path_(path), unit_m_(unit_m) {}

  ObjLevel convert(std::string_view text, const ObjLibrary& library) {
    load(text, library);
    convertMaterials();
    for (const tinyobj::shape_t& shape : shapes_) addShape(shape);
    noteLosses();
    level_.scene.id = std::filesystem::path(path_).stem().string();
    finishScene(level_.scene, world_positions_);
    return std::move(level_);
  }

 private:
  void load(std::string_view text, const ObjLibrary& library) {
    ObjText checked = checkedObjText(path_, text);
    faces_of_two_corners_ = checked.faces_of_two_corners;
    std::istringstream stream(std::move(checked.lines));
    LibraryReader libraries(library, &level_.notes);
    std::string warning, error;
    if (!tinyobj::LoadObj(&attributes_, &shapes_, &materials_, &warning, &error, &stream, &libraries, true)) {
      std::replace(error.begin(), error.end(), '\n', ' ');
      throw InputError(path_, "file", "a Wavefront .obj file", error.empty() ? "something else" : error.substr(0, 200));
    }
  }

  void convertMaterials() {
    for (const tinyobj::material_t& source : materials_) {
      Material material;
      bool is_clamped = false;
      for (int channel = 0; channel < 3; ++channel) {
        is_clamped = is_clamped || source.diffuse[channel] > 1.0;
        material.base_color[channel] = static_cast<float>(std::min<double>(source.diffuse[channel], 1.0));
        material.emissive[channel] = static_cast<float>(source.emission[channel]);
      }
      clamped_count_ += is_clamped ? 1 : 0;
      level_.scene.materials.push_back(material);
    }
    // the last one is of faces without
    level_.scene.materials.emplace_back();
  }

  void addShape(const tinyobj::shape_t& shape) {
    const std::vector<tinyobj::index_t>& corners = shape.mesh.indices;
    Scene& scene = level_.scene;
    const size_t triangle_count = corners.size() / 3;
    if (triangle_count == 0) return;
    const std::string name = shape.name.empty() ? "object " + std::to_string(scene.objects.size()) : shape.name;
    scene.objects.push_back({name, static_cast<uint32_t>(scene.triangles.size()), static_cast<uint32_t>(triangle_count), true});
    std::unordered_map<int, uint32_t> vertices;  // of the file → of the scene, within this shape
    for (size_t i = 0; i < triangle_count; ++i) {
      glm::uvec3 triangle;
      for (int k = 0; k < 3; ++k) triangle[k] = vertexOf(corners[3 * i + static_cast<size_t>(k)].vertex_index, &vertices);
      scene.triangles.push_back(triangle);
      const int material = shape.mesh.material_ids[i];
      faces_without_material_ += material < 0 ? 1 : 0;
      scene.triangle_material.push_back(material < 0 ? static_cast<uint32_t>(materials_.size())
                                                     : static_cast<uint32_t>(material));
    }
  }

  uint32_t vertexOf(int idx, std::unordered_map<int, uint32_t>* vertices) {
    const auto [entry, is_new] = vertices->emplace(idx, static_cast<uint32_t>(world_positions_.size()));
    if (!is_new) return entry->second;
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = unit_m_ * attributes_.vertices.at(3 * static_cast<size_t>(idx) + static_cast<size_t>(axis));
      if (!(std::abs(position[axis]) <= kFarthest))
        throw InputError(path_, "vertex " + std::to_string(idx + 1), "positions within 1e9 m of the origin",
                         std::to_string(position[axis]));
    }
    world_positions_.push_back(position);
    return entry->second;
  }

  void noteLosses() {
    std::vector<std::string>& notes = level_.notes;
    if (faces_without_material_ > 0)
      notes.push_back(std::to_string(faces_without_material_) + " triangles without a material that was found: grey");
    if (faces_of_two_corners_ > 0)
      notes.push_back(std::to_string(faces_of_two_corners_) + " faces of fewer than three corners: left out");
    if (clamped_count_ > 0) notes.push_back(std::to_string(clamped_count_) + " materials with a Kd above 1: cut to 1");
  }

  const std::string path_;
  const double unit_m_;
  tinyobj::attrib_t attributes_;
  std::vector<tinyobj::shape_t> shapes_;
  std::vector<tinyobj::material_t> materials_;
  std::vector<glm::dvec3> world_positions_;
  uint64_t faces_without_material_ = 0, faces_of_two_corners_ = 0, clamped_count_ = 0;
  ObjLevel level_;
};

}  // namespace

ObjLevel readObj(const std::string& path, double unit_m) {
  SceneBudget bytes_left = SceneBudgets().bytes;
  const std::vector<unsigned char> bytes = readSceneFile(path, "file", bytes_left);
  return readObjText(path, textOf(bytes), unit_m, librariesBeside(path, bytes_left));
}

ObjLevel readObjText(const std::string& path, std::string_view text, double unit_m, const ObjLibrary& library) {
  return ObjConverter(path, unit_m).convert(text, library);
}

}  // namespace nlg
