#include "scene/quake/bsp_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "scene/archive/pk3_archive.h"
#include "scene/archive/scene_file.h"
#include "scene/quake/bsp_entities.h"
#include "scene/quake/bsp_file.h"
#include "scene/quake/bsp_light.h"
#include "scene/quake/bsp_looks.h"
#include "scene/quake/bsp_patch.h"
#include "scene/quake/bsp_shader.h"
#include "scene/solid/closed_shells.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kLevelName = "worldspawn";
constexpr double kPatchToleranceUnits = 0.04 / kBspMetresPerUnit;
constexpr size_t kMaxLevelBytes = size_t{256} << 20;
constexpr size_t kMaxLightTexels = size_t{1} << 25;  // of all pages: beyond it each is kept smaller

std::string someOf(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size() && i < 8; ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > 8 ? text + " …" : text;
}

// A face as triangles, counter-clockwise from its front; one entry of each for a vertex.
struct FaceMesh {
  std::vector<glm::dvec3> positions_m;  // world coordinates
  std::vector<glm::vec2> lightmap_places, texture_places;
  std::vector<glm::vec3> light;
  std::vector<glm::uvec3> triangles;
};

glm::dvec3 worldPosition(const glm::dvec3& units) {
  // adding zero turns -0 into 0: components are found by comparing bits
  return sceneAxes(units) * kBspMetresPerUnit + 0.0;
}

// What a shader's faces are to the scene.
struct ShaderUse {
  const char* drop_reason = nullptr;  // null: they are geometry
  bool double_sided = false;
  glm::vec3 emission{0.0f};
  std::optional<uint32_t> material_idx;
};

// Faces that are no geometry but shine, and the sky that they show.
class LightFaces {
 public:
  void addSky(const FaceMesh& mesh, uint32_t shader) {
    append(mesh, sky_);
    double area = 0.0;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 a = mesh.positions_m[t.x];
      area += 0.5 * glm::length(glm::cross(mesh.positions_m[t.y] - a, mesh.positions_m[t.z] - a));
    }
    area_of_shader_[shader] += area;
  }

  void addShining(const FaceMesh& mesh, const ShaderUse& use) {
    append(mesh, shining_);
    shine_.resize(shining_.size(), use.emission);
    if (!use.double_sided) return;
    for (const glm::uvec3& t : mesh.triangles) shining_.push_back(glm::uvec3(t.x, t.z, t.y) + lastBase(mesh));
    shine_.resize(shining_.size(), use.emission);
  }

  size_t triangleCount() const { return sky_.size() + shining_.size(); }
  // Square metres of sky by shader.
  const std::map<uint32_t, double>& skyAreas() const { return area_of_shader_; }

  SkyFaces finish(const glm::dvec3& origin_m) {
    SkyFaces faces;
    faces.positions = relativeTo(origin_m, positions_m_);
    faces.triangles = std::move(sky_);
    faces.triangles.insert(faces.triangles.end(), shining_.begin(), shining_.end());
    faces.shine = std::move(shine_);
    return faces;
  }

 private:
  void append(const FaceMesh& mesh, std::vector<glm::uvec3>& triangles) {
    positions_m_.insert(positions_m_.end(), mesh.positions_m.begin(), mesh.positions_m.end());
    for (const glm::uvec3& t : mesh.triangles) triangles.push_back(t + lastBase(mesh));
  }
  uint32_t lastBase(const FaceMesh& mesh) const { return static_cast<uint32_t>(positions_m_.size() - mesh.positions_m.size()); }

  std::vector<glm::dvec3> positions_m_;
  std::vector<glm::uvec3> sky_, shining_;
  std::vector<glm::vec3> shine_;
  std::map<uint32_t, double> area_of_shader_;
};

class BspConverter {
 public:
  // looks    null when there are no archives
  BspConverter(const std::string& path, const std::string& bytes, const BspLooks* looks)
      : path_(path), file_(parseBsp(path, bytes)), looks_(looks), uses_(file_.shaders.size()) {}

  BspLevel convert(const std::string& id, double dense_transmissive) {
    level_.scene.id = id;
    const std::vector<BspEntity> entities = readEntities(path_, file_.entities);
    const std::vector<BspPlacement> placements = readPlacements(path_, entities, file_.models.size());
    for (size_t i = 0; i < file_.models.size(); ++i) {
      const std::string classname = placements[i].classname.empty() ? "submodel" : placements[i].classname;
      addModel(file_.models[i], i == 0 ? kLevelName : classname + " *" + std::to_string(i), placements[i].origin_units);
    }
    finishBakedLight();
    loadImages();
    finishScene(level_.scene, world_positions_);
    level_.notes = judgeTransmissive(level_.scene, material_names_, dense_transmissive);
    addLights(entities);
    addViewpoints(entities);
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
    if (face.kind == BspFaceKind::flare) {
      ++level_.dropped_faces["flare"];
      return;
    }
    const ShaderUse& use = useOf(face.shader);
    const bool is_sky = use.drop_reason != nullptr && std::string_view(use.drop_reason) == "sky";
    if (use.drop_reason != nullptr) ++level_.dropped_faces[use.drop_reason];
    if (use.drop_reason != nullptr && !is_sky && use.emission == glm::vec3(0.0f)) return;
    const uint64_t most =
        face.kind == BspFaceKind::patch ? maxPatchTriangles(face.patch_width, face.patch_height) : face.index_count / 3;
    // twice: one that shines may have two sides
    triangles_left_.require(2 * most, path_, "faces");
    const size_t before = triangleCount();
    const FaceMesh mesh = face.kind == BspFaceKind::patch ? patchMesh(face, origin_units) : triangleMesh(face, origin_units);
    if (is_sky) {
      light_faces_.addSky(mesh, face.shader);
    } else if (use.drop_reason != nullptr) {
      light_faces_.addShining(mesh, use);
    } else {
      addGeometry(face, mesh);
    }
    triangles_left_.take(triangleCount() - before, path_, "faces");
  }

  size_t triangleCount() const { return level_.scene.triangles.size() + light_faces_.triangleCount(); }

  void addGeometry(const BspFace& face, const FaceMesh& mesh) {
    Scene& scene = level_.scene;
    const glm::uvec3 base(static_cast<uint32_t>(world_positions_.size()));
    world_positions_.insert(world_positions_.end(), mesh.positions_m.begin(), mesh.positions_m.end());
    for (const glm::uvec3& triangle : mesh.triangles) scene.triangles.push_back(triangle + base);
    scene.triangle_material.resize(scene.triangles.size(), materialOf(face.shader));
    BakedLight& baked = scene.light.baked;
    baked.vertex_light.insert(baked.vertex_light.end(), mesh.light.begin(), mesh.light.end());
    scene.base_places.insert(scene.base_places.end(), mesh.texture_places.begin(), mesh.texture_places.end());
    baked.vertex_place.insert(baked.vertex_place.end(), mesh.lightmap_places.begin(), mesh.lightmap_places.end());
    const int32_t page = pageOf(face);
    baked.triangle_page.resize(scene.triangles.size(), page);
    if (page == BakedLight::kByVertex) ++by_vertex_[face.lightmap];
  }

  // In the file; or, of levels that were compiled with -external, in another that the shader names, or that is there by its number.
  int32_t pageOf(const BspFace& face) {
    if (face.lightmap >= 0 && static_cast<uint32_t>(face.lightmap) < file_.lightmap_count) return face.lightmap;
    if (looks_ == nullptr || looks_->need() == ImageNeed::geometry) return BakedLight::kByVertex;
    const ShaderScript* script = looks_->scriptOf(file_.shaders[face.shader].name);
    const std::string name = script != nullptr && !script->light_page.empty() ? script->light_page
                             : face.lightmap >= 0 ? fmt::format("maps/{}/lm_{:04}", level_.scene.id, face.lightmap)
                                                  : "";
    if (name.empty()) return BakedLight::kByVertex;
    const auto [entry, is_new] = page_of_file_.try_emplace(name, BakedLight::kByVertex);
    if (!is_new) return entry->second;
    std::optional<DecodedImage> image = looks_->page(name);
    if (image) light_texels_ += image->pixels.size() / 4;
    if (image && light_texels_ <= kMaxLightTexels) {
      entry->second = static_cast<int32_t>(file_.lightmap_count + pages_.size());
      pages_.push_back(std::move(*image));
    } else if (script != nullptr && name == script->light_page) {
      missing_pages_.push_back(name);
    }
    return entry->second;
  }

  // Polygons and meshes: clockwise in the file.
  FaceMesh triangleMesh(const BspFace& face, const glm::dvec3& origin_units) {
    FaceMesh mesh;
    const bool has_page = pageOf(face) != BakedLight::kByVertex;
    for (uint32_t i = face.first_vertex; i < face.first_vertex + face.vertex_count; ++i) {
      mesh.positions_m.push_back(worldPosition(glm::dvec3(file_.positions[i]) + origin_units));
      mesh.light.push_back(lightOf(file_.vertex_light[i].colour));
      mesh.lightmap_places.push_back(placeOf(has_page, file_.vertex_light[i].lightmap_place));
      mesh.texture_places.push_back(file_.texture_places[i]);
    }
    for (uint32_t i = face.first_index; i < face.first_index + face.index_count; i += 3)
      mesh.triangles.emplace_back(file_.indices[i], file_.indices[i + 2], file_.indices[i + 1]);
    return mesh;
  }

  FaceMesh patchMesh(const BspFace& face, const glm::dvec3& origin_units) {
    std::vector<glm::dvec3> control, light, places, texture_places;
    const bool has_page = pageOf(face) != BakedLight::kByVertex;
    for (uint32_t i = face.first_vertex; i < face.first_vertex + face.vertex_count; ++i) {
      control.push_back(glm::dvec3(file_.positions[i]) + origin_units);
      light.emplace_back(lightOf(file_.vertex_light[i].colour));
      places.emplace_back(placeOf(has_page, file_.vertex_light[i].lightmap_place), 0.0);
      texture_places.emplace_back(file_.texture_places[i], 0.0);
    }
    PatchMesh patch = tessellatePatch(control, face.patch_width, face.patch_height, kPatchToleranceUnits,
                                      {std::move(light), std::move(places), std::move(texture_places)});
    FaceMesh mesh;
    for (const glm::dvec3& p : patch.positions) mesh.positions_m.push_back(worldPosition(p));
    for (const glm::dvec3& l : patch.carried[0]) mesh.light.emplace_back(l);
    for (const glm::dvec3& p : patch.carried[1]) mesh.lightmap_places.emplace_back(p);
    for (const glm::dvec3& p : patch.carried[2]) mesh.texture_places.emplace_back(p);
    mesh.triangles = std::move(patch.triangles);
    return mesh;
  }

  // Numbers of faces without a page are garbage in real levels.
  static glm::vec2 placeOf(bool has_page, const glm::vec2& place) {
    const bool is_there = has_page && std::isfinite(place.x) && std::isfinite(place.y);
    return is_there ? glm::clamp(place, glm::vec2(0.0f), glm::vec2(1.0f)) : glm::vec2(0.0f);
  }

  ShaderUse& useOf(uint32_t shader_idx) {
    std::optional<ShaderUse>& use = uses_[shader_idx];
    if (use) return *use;
    const BspShader& shader = file_.shaders[shader_idx];
    const ShaderScript* script = looks_ != nullptr ? looks_->scriptOf(shader.name) : nullptr;
    use.emplace();
    use->drop_reason = dropReason(shader.surface_flags | (script != nullptr ? script->surface_flags : 0u),
                                  shader.content_flags | (script != nullptr ? script->content_flags : 0u));
    use->double_sided = script != nullptr && script->double_sided;
    if (looks_ != nullptr) use->emission = looks_->emission(shader.name);
    return *use;
  }

  uint32_t materialOf(uint32_t shader_idx) {
    ShaderUse& use = useOf(shader_idx);
    if (use.material_idx) return *use.material_idx;
    use.material_idx = static_cast<uint32_t>(level_.scene.materials.size());
    Material material;
    material.double_sided = use.double_sided;
    material.emissive = use.emission;
    const std::string& name = file_.shaders[shader_idx].name;
    if (looks_ != nullptr && looks_->keptAs(name).opacity != KeptAs::Opacity::none) material.transmissive = Transmissive::thin;
    level_.scene.materials.push_back(material);
    material_names_.push_back(name);
    return *use.material_idx;
  }

  // By point where a texture is at hand; of several the first that is not damaged.
  void loadImages() {
    Scene& scene = level_.scene;
    std::vector<std::vector<std::string>> entries(scene.materials.size());
    std::vector<size_t> pending;
    for (size_t i = 0; i < scene.materials.size(); ++i) {
      if (looks_ != nullptr) entries[i] = looks_->images(material_names_[i]);
      pending.push_back(i);
    }
    // one round, but for damaged images
    for (size_t round = 0; !pending.empty(); ++round) {
      ImageLoader loader(looks_ != nullptr ? looks_->need() : ImageNeed::all);
      std::vector<size_t> wanted;
      for (const size_t i : pending) {
        Material& material = scene.materials[i];
        if (round < entries[i].size()) {
          material.base_image.image = loader.want(entries[i][round], looks_->keptAs(material_names_[i]));
          if (material.base_image.isThere()) wanted.push_back(i);
        } else {
          ++level_.materials_without_texture;
          material.transmissive = Transmissive::none;
        }
      }
      pending.clear();
      if (wanted.empty()) break;
      LoadedImages loaded = looks_->load(loader);
      for (const size_t i : wanted) {
        Material& material = scene.materials[i];
        if (!loaded.take(&material.base_image)) {
          pending.push_back(i);
          continue;
        }
        material.base_color = glm::vec3(1.0f);
        material.base_image.image += static_cast<int32_t>(scene.images.size());
      }
      std::move(loaded.images.begin(), loaded.images.end(), std::back_inserter(scene.images));
    }
    if (scene.images.empty()) scene.base_places.clear();
  }

  // A level that was never lit has no lightmaps and one colour at all vertices.
  void finishBakedLight() {
    BakedLight& baked = level_.scene.light.baked;
    const std::vector<glm::vec3>& colours = baked.vertex_light;
    const bool is_lit = file_.lightmap_count + pages_.size() > 0 ||
                        std::any_of(colours.begin(), colours.end(), [&](const auto& c) { return c != colours[0]; });
    if (!is_lit) {
      const bool has_geometry = !colours.empty();
      baked = {};
      if (has_geometry) note("neither lightmaps nor lit vertices: no baked light" + byVertex());
      return;
    }
    if (!by_vertex_.empty()) note("faces that are lit by their vertices, as the engine does it" + byVertex());
    // one side for all
    baked.page_side = kBspLightmapSide;
    for (const DecodedImage& page : pages_) baked.page_side = std::max({baked.page_side, page.width, page.height});
    const size_t page_count = file_.lightmap_count + pages_.size();
    while (page_count * baked.page_side * baked.page_side > kMaxLightTexels && baked.page_side > 2) baked.page_side /= 2;
    const auto addPage = [&](int width, int height, const auto& texelOf) {
      for (int y = 0; y < baked.page_side; ++y) {
        for (int x = 0; x < baked.page_side; ++x)
          baked.texels.push_back(lightOf(texelOf(size_t(y * height / baked.page_side) * width + x * width / baked.page_side)));
      }
    };
    baked.texels.reserve(page_count * baked.page_side * baked.page_side);
    for (uint32_t page = 0; page < file_.lightmap_count; ++page) {
      const size_t first = size_t{page} * kBspLightmapSide * kBspLightmapSide;
      addPage(kBspLightmapSide, kBspLightmapSide, [&](size_t at) { return file_.lightmap_texels[first + at]; });
    }
    for (const DecodedImage& page : pages_)
      addPage(page.width, page.height, [&](size_t at) {
        return BspColour{page.pixels[4 * at], page.pixels[4 * at + 1], page.pixels[4 * at + 2]};
      });
  }

  // By the number in the place of a lightmap's, and the files that are not there.
  std::string byVertex() const {
    std::string text;
    for (const auto& [number, count] : by_vertex_)
      text += fmt::format("{} {} of lightmap {}", text.empty() ? ":" : ",", count, number);
    if (!missing_pages_.empty()) text += ", whose pages are not read: " + someOf(missing_pages_);
    return text;
  }

  // Eyes stand 26 units above a player's origin (bg_public.h, DEFAULT_VIEWHEIGHT).
  void addViewpoints(const std::vector<BspEntity>& entities) {
    constexpr double kEyeUnits = 26.0;
    for (const BspStart& start : playerStarts(entities)) {
      Viewpoint viewpoint;
      viewpoint.name = start.name;
      viewpoint.position = glm::vec3(worldPosition(start.origin_units + glm::dvec3(0.0, 0.0, kEyeUnits)) - level_.scene.origin_m);
      const double turn = glm::radians(start.turn_degrees);
      viewpoint.forward = glm::vec3(glm::normalize(sceneAxes({std::cos(turn), std::sin(turn), 0.0})));
      level_.scene.viewpoints.push_back(viewpoint);
    }
  }

  void addLights(const std::vector<BspEntity>& entities) {
    SceneLight& light = level_.scene.light;
    const glm::dvec3& origin_m = level_.scene.origin_m;
    EntityLights lights = entityLights(entities);
    for (size_t i = 0; i < lights.lamps.size(); ++i)
      lights.lamps[i].position = glm::vec3(worldPosition(lights.lamp_units[i]) - origin_m);
    light.lamps = std::move(lights.lamps);
    light.suns = std::move(lights.suns);
    if (!light.baked.empty()) light.baked.ambient = lights.ambient;
    if (lights.lamps_without_origin > 0) note(std::to_string(lights.lamps_without_origin) + " lamps without an origin: left out");
    if (lights.linear_lamps > 0)
      note(std::to_string(lights.linear_lamps) + " lamps that fade linearly: by the square of the distance instead");
    addSky(lights.has_shader_suns);
    light.sky_faces = light_faces_.finish(origin_m);
  }

  // Of several skies the mean by area: a scene has one.
  void addSky(bool has_suns) {
    if (looks_ == nullptr) return;
    double total = 0.0;
    for (const auto& [shader, area] : light_faces_.skyAreas()) total += area;
    if (!(total > 0.0)) return;
    Sky& sky = level_.scene.light.sky;
    for (const auto& [shader, area] : light_faces_.skyAreas()) {
      const std::string& name = file_.shaders[shader].name;
      const Sky one = looks_->sky(name);
      const auto share = static_cast<float>(area / total);
      sky.zenith += share * one.zenith;
      sky.horizon += share * one.horizon;
      sky.ground += share * one.ground;
      const ShaderScript* script = looks_->scriptOf(name);
      if (script == nullptr || !has_suns) continue;
      for (const ScriptSun& sun : script->light.suns) level_.scene.light.suns.push_back(sunOf(sun));
    }
    if (light_faces_.skyAreas().size() > 1)
      note(std::to_string(light_faces_.skyAreas().size()) + " sky shaders: one sky, their mean by area");
  }

  void note(const std::string& line) { level_.light_notes.push_back(line); }

  const std::string path_;
  const BspFile file_;
  const BspLooks* looks_;
  std::vector<std::optional<ShaderUse>> uses_;  // by shader
  std::vector<glm::dvec3> world_positions_;
  std::vector<std::string> material_names_;  // by material of the scene: its shader
  LightFaces light_faces_;
  SceneBudget triangles_left_ = SceneBudgets().level_triangles;
  size_t light_texels_ = 0;                      // of pages in files
  std::vector<DecodedImage> pages_;              // of light, in files
  std::map<std::string, int32_t> page_of_file_;  // behind those of the level; or kByVertex
  std::vector<std::string> missing_pages_;
  std::map<int32_t, uint32_t> by_vertex_;  // faces, by the number of their lightmap
  BspLevel level_;
};

}  // namespace

BspLevel readBsp(const std::string& path) {
  return BspConverter(path, readFile(path, kMaxLevelBytes), nullptr)
      .convert(std::filesystem::path(path).stem().string(), kDenseTransmissive);
}

BspLevel readBspFromArchives(const std::string& path, const std::string& map, double dense_transmissive, ImageNeed need) {
  const Pk3Archives archives(path);
  const std::string id = lowerCase(map);
  const std::string name = "maps/" + id + ".bsp";
  if (id.empty() || id.find('/') != std::string::npos || !archives.has(name)) {
    std::vector<std::string> maps;
    for (const std::string& found : archives.names("maps/", ".bsp")) maps.push_back(found.substr(5, found.size() - 9));
    throw InputError(path, "map \"" + map.substr(0, 80) + "\"", maps.empty() ? "archives with maps" : "one of " + someOf(maps),
                     "none of that name");
  }
  const BspLooks looks(archives, need);
  return BspConverter(path + ":" + id, archives.read(name, kMaxLevelBytes), &looks).convert(id, dense_transmissive);
}

}  // namespace nlg
