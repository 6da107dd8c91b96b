#include "datagen/scene/bsp_reader.h"

#include <filesystem>
#include <optional>

#include "datagen/scene/bsp_entities.h"
#include "datagen/scene/bsp_file.h"
#include "datagen/scene/bsp_patch.h"
#include "datagen/scene/bsp_shader.h"
#include "datagen/scene/free_standing.h"
#include "datagen/scene/pk3_archive.h"
#include "datagen/scene/texture_colour.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kLevelName = "worldspawn";
constexpr double kMetresPerUnit = 0.0254;
constexpr double kPatchToleranceUnits = 0.04 / kMetresPerUnit;
constexpr size_t kMaxLevelBytes = size_t{256} << 20;
constexpr size_t kMaxTextureBytes = size_t{64} << 20;
constexpr uint64_t kMaxTriangles = uint64_t{1} << 23;

// Scripts and textures of the archives that a level came from.
struct LevelLooks {
  const Pk3Archives& archives;
  ShaderScripts scripts;
};

class BspConverter {
 public:
  // looks    null when there are no archives
  BspConverter(const std::string& path, const std::string& bytes, const LevelLooks* looks)
      : path_(path), file_(parseBsp(path, bytes)), looks_(looks), material_of_shader_(file_.shaders.size()) {}

  BspLevel convert(const std::string& id) {
    level_.scene.id = id;
    const std::vector<BspPlacement> placements = readPlacements(path_, file_.entities, file_.models.size());
    for (size_t i = 0; i < file_.models.size(); ++i) {
      const std::string classname = placements[i].classname.empty() ? "submodel" : placements[i].classname;
      addModel(file_.models[i], i == 0 ? kLevelName : classname + " *" + std::to_string(i), placements[i].origin_units);
    }
    finishScene(level_.scene, world_positions_);
    const std::vector<SceneObject>& objects = level_.scene.objects;
    if (!objects.empty() && objects[0].name == kLevelName) splitFreeStanding(level_.scene, 0);
    return std::move(level_);
  }

 private:
  void addModel(const BspModel& model, const std::string& name, const glm::dvec3& origin_units) {
    const auto first_triangle = static_cast<uint32_t>(level_.scene.triangles.size());
    for (uint32_t i = model.first_face; i < model.first_face + model.face_count; ++i) addFace(file_.faces[i], origin_units);
    const auto count = static_cast<uint32_t>(level_.scene.triangles.size()) - first_triangle;
    if (count > 0) level_.scene.objects.push_back({name, first_triangle, count, true});
  }

  void addFace(const BspFace& face, const glm::dvec3& origin_units) {
    const BspShader& shader = file_.shaders[face.shader];
    const ShaderScript* script = scriptOf(shader);
    const uint32_t surface_flags = shader.surface_flags | (script != nullptr ? script->surface_flags : 0u);
    const uint32_t content_flags = shader.content_flags | (script != nullptr ? script->content_flags : 0u);
    const char* reason = face.kind == BspFaceKind::flare ? "flare" : dropReason(surface_flags, content_flags);
    if (reason != nullptr) {
      ++level_.dropped_faces[reason];
      return;
    }
    const uint64_t more =
        face.kind == BspFaceKind::patch ? maxPatchTriangles(face.patch_width, face.patch_height) : face.index_count / 3;
    if (level_.scene.triangles.size() + more > kMaxTriangles) fail("triangles", "at most 2^23", "more");
    if (face.kind == BspFaceKind::patch) {
      addPatch(face, origin_units);
    } else {
      addTriangles(face, origin_units);
    }
    level_.scene.triangle_material.resize(level_.scene.triangles.size(), materialOf(face.shader));
  }

  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }

  void addPosition(const glm::dvec3& units) {
    // adding zero turns -0 into 0: components are found by comparing bits
    world_positions_.push_back(glm::dvec3(units.x, units.z, -units.y) * kMetresPerUnit + 0.0);
  }

  // Polygons and meshes: clockwise in the file.
  void addTriangles(const BspFace& face, const glm::dvec3& origin_units) {
    const auto base = static_cast<uint32_t>(world_positions_.size());
    for (uint32_t i = 0; i < face.vertex_count; ++i)
      addPosition(glm::dvec3(file_.positions[face.first_vertex + i]) + origin_units);
    for (uint32_t i = face.first_index; i < face.first_index + face.index_count; i += 3) {
      level_.scene.triangles.emplace_back(base + file_.indices[i], base + file_.indices[i + 2], base + file_.indices[i + 1]);
    }
  }

  void addPatch(const BspFace& face, const glm::dvec3& origin_units) {
    std::vector<glm::dvec3> control;
    for (uint32_t i = 0; i < face.vertex_count; ++i) {
      control.push_back(glm::dvec3(file_.positions[face.first_vertex + i]) + origin_units);
    }
    const PatchMesh mesh = tessellatePatch(control, face.patch_width, face.patch_height, kPatchToleranceUnits);
    const auto base = static_cast<uint32_t>(world_positions_.size());
    for (const glm::dvec3& p : mesh.positions) addPosition(p);
    for (const glm::uvec3& triangle : mesh.triangles) level_.scene.triangles.push_back(triangle + base);
  }

  const ShaderScript* scriptOf(const BspShader& shader) const {
    if (looks_ == nullptr) return nullptr;
    const auto found = looks_->scripts.find(shaderKey(shader.name));
    return found == looks_->scripts.end() ? nullptr : &found->second;
  }

  uint32_t materialOf(uint32_t shader_idx) {
    std::optional<uint32_t>& material_idx = material_of_shader_[shader_idx];
    if (material_idx) return *material_idx;
    material_idx = static_cast<uint32_t>(level_.scene.materials.size());
    const BspShader& shader = file_.shaders[shader_idx];
    const ShaderScript* script = scriptOf(shader);
    Material material;
    material.double_sided = script != nullptr && script->double_sided;
    const std::optional<glm::vec3> colour = textureColour(shader, script);
    if (colour) material.base_color = *colour;
    if (!colour) ++level_.materials_without_texture;
    level_.scene.materials.push_back(material);
    return *material_idx;
  }

  std::optional<glm::vec3> textureColour(const BspShader& shader, const ShaderScript* script) const {
    if (looks_ == nullptr) return std::nullopt;
    std::vector<std::string> names;
    if (script != nullptr) names = script->textures;
    names.push_back(shaderKey(shader.name));
    for (const std::string& name : names) {
      for (const char* suffix : {".tga", ".jpg"}) {
        if (!looks_->archives.has(name + suffix)) continue;
        const std::optional<glm::vec3> colour = averageColour(looks_->archives.read(name + suffix, kMaxTextureBytes));
        if (colour) return colour;
      }
    }
    return std::nullopt;
  }

  const std::string path_;
  const BspFile file_;
  const LevelLooks* looks_;
  std::vector<std::optional<uint32_t>> material_of_shader_;
  std::vector<glm::dvec3> world_positions_;
  BspLevel level_;
};

std::string someOf(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size() && i < 8; ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > 8 ? text + " …" : text;
}

}  // namespace

BspLevel readBsp(const std::string& path) {
  return BspConverter(path, readFile(path, kMaxLevelBytes), nullptr).convert(std::filesystem::path(path).stem().string());
}

BspLevel readBspFromArchives(const std::string& path, const std::string& map) {
  const Pk3Archives archives(path);
  const std::string id = lowerCase(map);
  const std::string name = "maps/" + id + ".bsp";
  if (id.empty() || id.find('/') != std::string::npos || !archives.has(name)) {
    std::vector<std::string> maps;
    for (const std::string& found : archives.names("maps/", ".bsp")) maps.push_back(found.substr(5, found.size() - 9));
    throw InputError(path, "map \"" + map.substr(0, 80) + "\"", maps.empty() ? "archives with maps" : "one of " + someOf(maps),
                     "none of that name");
  }
  const LevelLooks looks{archives, readShaderScripts(archives)};
  return BspConverter(path + ":" + id, archives.read(name, kMaxLevelBytes), &looks).convert(id);
}

}  // namespace nlg
