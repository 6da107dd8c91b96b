#include "scene/interiors/furniture_library.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "scene/model/surface_look.h"
#include "scene/obj/obj_reader.h"
#include "scene/procedural/mesh_builder.h"
#include "scene/solid/closed_shells.h"
#include "scene/solid/transmissive.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kFirstCellM = 0.004, kCellGrowth = 1.3, kLargestCellShare = 1.0 / 20.0;

using Cell = std::tuple<int64_t, int64_t, int64_t>;

// Positions turned upright and stretched to the entry's box, which stands on y = 0 around the origin.
std::vector<glm::dvec3> uprightPositions(const Scene& model, const CatalogueEntry& entry) {
  std::vector<glm::dvec3> positions;
  glm::dvec3 low(1e30), high(-1e30);
  for (const glm::vec3& p : model.positions) {
    positions.push_back(glm::dvec3(p) * entry.rotation);
    low = glm::min(low, positions.back());
    high = glm::max(high, positions.back());
  }
  for (glm::dvec3& p : positions) {
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = high[axis] - low[axis];
      const double share = extent > 0.0 ? (p[axis] - low[axis]) / extent : 0.5;
      p[axis] = entry.size_m[axis] * (axis == 1 ? share : share - 0.5);
    }
  }
  return positions;
}

struct Mesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> triangle_material;
};

// Merges the vertices of each cell at their mean; triangles without area and those that are there already are left out.
Mesh merged(const Mesh& fine, double cell_m) {
  Mesh mesh;
  // vertex clustering (Rossignac and Borrel 1993): it needs no connectivity of the model
  std::map<Cell, uint32_t> cells;
  std::vector<uint32_t> cell_of(fine.positions.size());
  std::vector<uint32_t> member_count;
  for (size_t i = 0; i < fine.positions.size(); ++i) {
    std::array<int64_t, 3> key{};
    for (int axis = 0; axis < 3; ++axis) key[axis] = static_cast<int64_t>(std::floor(fine.positions[i][axis] / cell_m + 0.5));
    const auto [entry, is_new] = cells.try_emplace({key[0], key[1], key[2]}, static_cast<uint32_t>(mesh.positions.size()));
    if (is_new) {
      mesh.positions.emplace_back(0.0);
      member_count.push_back(0);
    }
    cell_of[i] = entry->second;
    mesh.positions[entry->second] += fine.positions[i];
    ++member_count[entry->second];
  }
  // the grid of 1/1024 m is exact in float, so that joined edges stay bit-identical
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis)
      mesh.positions[i][axis] = snapped(mesh.positions[i][axis] / member_count[i], kVerticesPerMetre);
  }
  // the least index comes first: equal faces have one key, and the two sides of a sheet have two
  std::set<std::tuple<uint32_t, uint32_t, uint32_t>> known;
  for (size_t i = 0; i < fine.triangles.size(); ++i) {
    glm::uvec3 t(cell_of[fine.triangles[i].x], cell_of[fine.triangles[i].y], cell_of[fine.triangles[i].z]);
    const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    if (normal == glm::dvec3(0.0)) continue;
    while (t.x > t.y || t.x > t.z) t = {t.y, t.z, t.x};
    if (!known.emplace(t.x, t.y, t.z).second) continue;
    mesh.triangles.push_back(t);
    mesh.triangle_material.push_back(fine.triangle_material[i]);
  }
  return mesh;
}

std::vector<Material> plainMaterials(const Scene& scene) {
  std::vector<Material> plain = scene.materials;
  std::vector<bool> has_base, has_emissive;
  for (const Material& material : scene.materials) {
    has_base.push_back(material.base_image.isThere());
    has_emissive.push_back(material.emissive_image.isThere());
  }
  const auto base = [&](uint32_t triangle, float u, float v) { return glm::dvec3(baseColourAt(scene, triangle, u, v)); };
  const auto emission = [&](uint32_t triangle, float u, float v) { return glm::dvec3(emissionAt(scene, triangle, u, v)); };
  const std::vector<glm::dvec4> colours = meansOfMaterials(scene, has_base, base);
  const std::vector<glm::dvec4> shines = meansOfMaterials(scene, has_emissive, emission);
  for (size_t i = 0; i < plain.size(); ++i) {
    if (has_base[i]) plain[i].base_color = glm::vec3(colours[i]);
    if (has_emissive[i]) plain[i].emissive = glm::vec3(shines[i]);
    plain[i].base_image = plain[i].emissive_image = {};
    plain[i].transmissive = Transmissive::none;
    plain[i].opacity = 1.0f;
  }
  return plain;
}

void giveMaterials(const Scene& source, const Mesh& mesh, FurnitureModel* model) {
  const std::vector<Material> materials = plainMaterials(source);
  std::vector<uint32_t> itself(mesh.positions.size());  // merged before: no two vertices are the same
  std::iota(itself.begin(), itself.end(), 0u);
  ShellFinder finder(std::move(itself));
  const Components components = finder.components(mesh.triangles);
  const std::vector<Shell> shells = finder.measure(mesh.positions, mesh.triangles, components);
  std::map<std::pair<uint32_t, bool>, uint32_t> copies;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Shell& shell = shells[components.of_triangle[i]];
    const bool is_one_sided = shell.open_length_m == 0.0 && shell.volume_m3 > 0.0;
    const auto [copy, is_new] =
        copies.try_emplace({mesh.triangle_material[i], is_one_sided}, static_cast<uint32_t>(model->materials.size()));
    if (is_new) {
      model->materials.push_back(materials[mesh.triangle_material[i]]);
      model->materials.back().double_sided = !is_one_sided;
    }
    model->triangle_material.push_back(copy->second);
  }
}

namespace fs = std::filesystem;

constexpr size_t kMaxCatalogueBytes = size_t{4} << 20;
constexpr size_t kMaxImageBytes = size_t{64} << 20;
constexpr size_t kMaxModelBytes = size_t{8} << 20;

}  // namespace

FurnitureModel fitFurnitureModel(const Scene& model, const CatalogueEntry& entry) {
  FurnitureModel result;
  const Mesh raw{uprightPositions(model, entry), model.triangles, model.triangle_material};
  Mesh mesh = merged(raw, 1.0 / kVerticesPerMetre);
  const double largest_m = kLargestCellShare * std::max({entry.size_m.x, entry.size_m.y, entry.size_m.z});
  for (double cell_m = kFirstCellM; mesh.triangles.size() > kModelTriangleBudget && cell_m <= largest_m; cell_m *= kCellGrowth)
    mesh = merged(mesh, cell_m);
  if (mesh.triangles.empty() || mesh.triangles.size() > kModelTriangleBudget) return result;
  giveMaterials(model, mesh, &result);
  result.positions = std::move(mesh.positions);
  result.triangles = std::move(mesh.triangles);
  return result;
}

FurnitureLibrary::FurnitureLibrary(const std::string& path) {
  for (const std::string& file : archiveFiles(path, ".sh3f")) addArchive(file);
}

void FurnitureLibrary::addArchive(const std::string& file) {
  auto archive = std::make_unique<Pk3Archives>(file, &unpacked_);
  const std::string text = archive->read("PluginFurnitureCatalog.properties", kMaxCatalogueBytes);
  const std::vector<CatalogueEntry> entries = parseCatalogue(file, text);
  if (entries.empty()) throw InputError(file, "catalogue", "pieces", "none");
  for (const CatalogueEntry& entry : entries) {
    by_use_[furnitureUse(entry)].push_back(pieces_.size());
    pieces_.push_back({entry, archives_.size(), std::nullopt});
  }
  archives_.push_back(std::move(archive));
}

const std::vector<size_t>& FurnitureLibrary::pieces(FurnitureUse use) const {
  static const std::vector<size_t> none;
  const auto found = by_use_.find(use);
  return found == by_use_.end() ? none : found->second;
}

const FurnitureModel* FurnitureLibrary::model(size_t idx) {
  Piece& piece = pieces_.at(idx);
  if (!piece.model) {
    piece.model = read(piece);
    ++(piece.model->triangles.empty() ? too_fine_count_ : model_count_);
  }
  return piece.model->triangles.empty() ? nullptr : &*piece.model;
}

FurnitureModel FurnitureLibrary::read(const Piece& piece) {
  const std::string& name = piece.entry.model;
  const Pk3Archives& archive = *archives_[piece.archive_idx];
  if (extensionOf(name) != ".obj" || archive.sizeOf(name) > kMaxModelBytes) return {};
  const std::string text = archive.read(name, kMaxModelBytes);
  // an .obj names its materials and images relative to itself, in the same archive
  const auto library = [&](const std::string& library_name) {
    ObjLibraryFile file;
    file.key = (fs::path(name).parent_path() / library_name).lexically_normal().string();
    file.path = archive.path() + ": " + file.key;
    if (!archive.has(file.key)) {
      file.problem = "is not there";
    } else {
      file.read = [&archive, key = file.key] { return archive.read(key, kMaxCatalogueBytes); };
    }
    return file;
  };
  const auto image = [&](const std::string& image_name) {
    ImageBytes bytes;
    const std::string key = (fs::path(name).parent_path() / image_name).lexically_normal().string();
    if (!archive.has(key)) {
      bytes.problem = "is not there";
    } else {
      const std::string entry = archive.read(key, kMaxImageBytes);
      bytes.own.assign(entry.begin(), entry.end());
    }
    return bytes;
  };
  const std::string path = archive.path() + ": " + name;
  return fitFurnitureModel(readObjText(path, text, 1.0, {library, image, &pixels_}).scene, piece.entry);
}

}  // namespace nlg
