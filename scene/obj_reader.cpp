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

bool isElsewhere(const std::string& name) { return name.find_first_of("\\:") != std::string::npos || name[0] == '/'; }

// Opens the material libraries that a file names: those in its folder or below.
// bytes_left   must outlive what is returned
ObjLibrary librariesBeside(const std::string& path, SceneBudget& bytes_left) {
  return [path, &bytes_left](const std::string& name) {
    ObjLibraryFile file;
    const bool is_beside = !isElsewhere(name);
    if (!is_beside) file.problem = "is a path of another place: not opened";
    if (is_beside && isMissingBeside(path, name)) file.problem = "is not there";
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
    const size_t first = materials->size();
    tinyobj::LoadMtl(by_name, materials, &stream, warning, error);
    // images are named from where the library lies
    const std::filesystem::path folder = std::filesystem::path(name).parent_path();
    for (size_t i = first; i < materials->size(); ++i) {
      tinyobj::material_t& material = (*materials)[i];
      for (std::string* image : {&material.diffuse_texname, &material.emissive_texname, &material.alpha_texname})
        *image = imageName(folder, *image);
    }
    return true;
  }

 private:
  // Of programs of Windows, too.
  static std::string imageName(const std::filesystem::path& folder, std::string name) {
    name.resize(name.find_last_not_of(" \t\r") + 1);
    std::replace(name.begin(), name.end(), '\\', '/');
    return name.empty() ? name : (folder / name).lexically_normal().string();
  }

  const ObjLibrary& library_;
  std::vector<std::string>* notes_;
  std::set<std::string> opened_;  // by key
};

// How a material's images lie on its places (vt): from the lower left corner, times scale, plus offset.
struct ObjPlacing {
  glm::dvec2 base_scale{1.0}, base_offset{0.0}, emissive_scale{1.0}, emissive_offset{0.0};
  bool operator==(const ObjPlacing&) const = default;
};

class ObjConverter {
 public:
  ObjConverter(const std::string& path, double unit_m, const ObjFiles& files) : path_(path), unit_m_(unit_m), files_(files) {}

  ObjLevel convert(std::string_view text, double dense_veil) {
    load(text, files_.library);
    convertMaterials();
    loadImages();
    for (const tinyobj::shape_t& shape : shapes_) addShape(shape);
    noteLosses();
    level_.scene.id = std::filesystem::path(path_).stem().string();
    finishScene(level_.scene, world_positions_);
    std::vector<std::string> names;
    for (const tinyobj::material_t& source : materials_) names.push_back(source.name);
    for (std::string& note : judgeVeils(level_.scene, names, dense_veil)) level_.notes.push_back(std::move(note));
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
    std::set<int> used;
    for (const tinyobj::shape_t& shape : shapes_) used.insert(shape.mesh.material_ids.begin(), shape.mesh.material_ids.end());
    for (size_t i = 0; i < materials_.size(); ++i) {
      const tinyobj::material_t& source = materials_[i];
      Material material;
      material.label.name = source.name;
      bool is_clamped = false;
      for (int channel = 0; channel < 3; ++channel) {
        is_clamped = is_clamped || source.diffuse[channel] > 1.0;
        material.base_color[channel] = static_cast<float>(std::min<double>(source.diffuse[channel], 1.0));
        material.emissive[channel] = static_cast<float>(source.emission[channel]);
      }
      clamped_count_ += is_clamped ? 1 : 0;
      if (source.dissolve < 1.0) material.veil = Veil::thin;  // what it is in truth is judged once the scene is there
      material.opacity = static_cast<float>(source.dissolve);
      if (used.count(static_cast<int>(i)) > 0) wantImages(source, &material);
      level_.scene.materials.push_back(material);
      placings_.push_back(placingOf(source));
    }
    // the last one is of faces without
    level_.scene.materials.emplace_back();
  }

  void wantImages(const tinyobj::material_t& source, Material* material) {
    const std::string &colour = source.diffuse_texname, &opacity = source.alpha_texname;
    KeptAs kept;
    if (!opacity.empty()) {
      material->veil = Veil::thin;
      if (opacity == colour || colour.empty()) kept.opacity = KeptAs::Opacity::brightness;
      if (opacity != colour && !colour.empty()) kept.opacity_of = opacity;
      if (colour.empty()) kept.colour = KeptAs::Colour::white;
    }
    const auto want = [&](const std::string& name, const KeptAs& as, const tinyobj::texture_option_t& options, TextureUse* use) {
      if (name.empty()) return;
      use->image = loader_.want(name, as);
      if (options.clamp) use->wrap_u = use->wrap_v = TextureWrap::clamp;
    };
    want(colour.empty() ? opacity : colour, kept, colour.empty() ? source.alpha_texopt : source.diffuse_texopt,
         &material->base_image);
    if (material->emissive != glm::vec3(0.0f))
      want(source.emissive_texname, {}, source.emissive_texopt, &material->emissive_image);
  }

  static ObjPlacing placingOf(const tinyobj::material_t& source) {
    const tinyobj::texture_option_t& base = source.diffuse_texname.empty() ? source.alpha_texopt : source.diffuse_texopt;
    const tinyobj::texture_option_t& emissive = source.emissive_texopt;
    const auto pair = [](const tinyobj::real_t* numbers) { return glm::dvec2(numbers[0], numbers[1]); };
    return {pair(base.scale), pair(base.origin_offset), pair(emissive.scale), pair(emissive.origin_offset)};
  }

  void loadImages() {
    if (loader_.wantsNone()) return;
    LoadedImages loaded = loader_.load(files_.image, *files_.pixels, path_);
    for (Material& material : level_.scene.materials) {
      if (!loaded.take(&material.base_image)) material.base_color *= kUnreadGrey;
      if (!loaded.take(&material.emissive_image)) material.emissive = glm::vec3(0.0f);
      has_base_places_ |= material.base_image.isThere();
      has_emissive_places_ |= material.emissive_image.isThere();
    }
    level_.scene.images = std::move(loaded.images);
    for (std::string& note : unreadImageNotes(loaded)) level_.notes.push_back(std::move(note));
  }

  void addShape(const tinyobj::shape_t& shape) {
    const std::vector<tinyobj::index_t>& corners = shape.mesh.indices;
    Scene& scene = level_.scene;
    const size_t triangle_count = corners.size() / 3;
    if (triangle_count == 0) return;
    const std::string name = shape.name.empty() ? "object " + std::to_string(scene.objects.size()) : shape.name;
    scene.objects.push_back({name, static_cast<uint32_t>(scene.triangles.size()), static_cast<uint32_t>(triangle_count), true});
    VertexMap vertices;
    for (size_t i = 0; i < triangle_count; ++i) {
      glm::uvec3 triangle;
      const int material = shape.mesh.material_ids[i];
      const size_t material_idx = material < 0 ? materials_.size() : static_cast<size_t>(material);
      for (int k = 0; k < 3; ++k) triangle[k] = vertexOf(corners[3 * i + static_cast<size_t>(k)], material_idx, &vertices);
      scene.triangles.push_back(triangle);
      faces_without_material_ += material < 0 ? 1 : 0;
      scene.triangle_material.push_back(static_cast<uint32_t>(material_idx));
    }
  }

  // What makes a vertex of the scene: one of the file, and where there is an image its place and material, too.
  struct VertexKey {
    int vertex, place;
    size_t material;
    bool operator==(const VertexKey&) const = default;
  };
  struct KeyHash {
    size_t operator()(const VertexKey& key) const {
      return static_cast<size_t>(key.vertex) + static_cast<size_t>(key.place) * 0x9e3779b97f4a7c15u +
             key.material * 0xc2b2ae3d27d4eb4fu;
    }
  };
  using VertexMap = std::unordered_map<VertexKey, uint32_t, KeyHash>;  // of one shape

  uint32_t vertexOf(const tinyobj::index_t& corner, size_t material_idx, VertexMap* vertices) {
    Scene& scene = level_.scene;
    const Material& material = scene.materials[material_idx];
    const bool has_image = material.base_image.isThere() || material.emissive_image.isThere();
    const VertexKey key{corner.vertex_index, has_image ? corner.texcoord_index : -1, has_image ? material_idx : 0};
    const auto [entry, is_new] = vertices->emplace(key, static_cast<uint32_t>(world_positions_.size()));
    if (!is_new) return entry->second;
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] =
          unit_m_ * attributes_.vertices.at(3 * static_cast<size_t>(corner.vertex_index) + static_cast<size_t>(axis));
      if (!(std::abs(position[axis]) <= kFarthest))
        throw InputError(path_, "vertex " + std::to_string(corner.vertex_index + 1), "positions within 1e9 m of the origin",
                         std::to_string(position[axis]));
    }
    world_positions_.push_back(position);
    if (has_base_places_)
      scene.base_places.push_back(material.base_image.isThere() ? basePlace(corner, placings_[material_idx]) : glm::vec2(0.0f));
    if (has_emissive_places_)
      scene.emissive_places.push_back(material.emissive_image.isThere() ? emissivePlace(corner, placings_[material_idx])
                                                                        : glm::vec2(0.0f));
    return entry->second;
  }

  glm::vec2 basePlace(const tinyobj::index_t& corner, const ObjPlacing& placing) {
    return placeOf(corner, placing.base_scale, placing.base_offset);
  }
  glm::vec2 emissivePlace(const tinyobj::index_t& corner, const ObjPlacing& placing) {
    return placeOf(corner, placing.emissive_scale, placing.emissive_offset);
  }

  // v points up in the file, and down in the scene.
  glm::vec2 placeOf(const tinyobj::index_t& corner, const glm::dvec2& scale, const glm::dvec2& offset) {
    const auto at = 2 * static_cast<size_t>(corner.texcoord_index);
    const bool is_there = corner.texcoord_index >= 0 && at + 1 < attributes_.texcoords.size();
    const glm::dvec2 place =
        is_there ? glm::dvec2(attributes_.texcoords[at], attributes_.texcoords[at + 1]) * scale + offset : glm::dvec2(NAN);
    if (!std::isfinite(place.x) || !std::isfinite(place.y)) {
      ++unplaced_count_;
      return glm::vec2(0.0f);
    }
    return glm::vec2(glm::clamp(glm::dvec2(place.x, 1.0 - place.y), glm::dvec2(-1e9), glm::dvec2(1e9)));
  }

  void noteLosses() {
    std::vector<std::string>& notes = level_.notes;
    if (faces_without_material_ > 0)
      notes.push_back(std::to_string(faces_without_material_) + " triangles without a material that was found: grey");
    if (faces_of_two_corners_ > 0)
      notes.push_back(std::to_string(faces_of_two_corners_) + " faces of fewer than three corners: left out");
    if (unplaced_count_ > 0)
      notes.push_back(std::to_string(unplaced_count_) + " vertices without a place on their image (vt): its corner instead");
    if (clamped_count_ > 0) notes.push_back(std::to_string(clamped_count_) + " materials with a Kd above 1: cut to 1");
  }

  const std::string path_;
  const double unit_m_;
  const ObjFiles& files_;
  ImageLoader loader_;
  std::vector<ObjPlacing> placings_;  // by material
  bool has_base_places_ = false, has_emissive_places_ = false;
  tinyobj::attrib_t attributes_;
  std::vector<tinyobj::shape_t> shapes_;
  std::vector<tinyobj::material_t> materials_;
  std::vector<glm::dvec3> world_positions_;
  uint64_t faces_without_material_ = 0, faces_of_two_corners_ = 0, clamped_count_ = 0, unplaced_count_ = 0;
  ObjLevel level_;
};

}  // namespace

ObjLevel readObj(const std::string& path, double unit_m, double dense_veil) {
  SceneBudgets budgets;
  const std::vector<unsigned char> bytes = readSceneFile(path, "file", budgets.bytes);
  const auto image = [&](const std::string& name) { return imageBeside(path, isElsewhere(name) ? "" : name, budgets.bytes); };
  return readObjText(path, textOf(bytes), unit_m, {librariesBeside(path, budgets.bytes), image, &budgets.pixels}, dense_veil);
}

ObjLevel readObjText(const std::string& path, std::string_view text, double unit_m, const ObjFiles& files, double dense_veil) {
  return ObjConverter(path, unit_m, files).convert(text, dense_veil);
}

}  // namespace nlg
