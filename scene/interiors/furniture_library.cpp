#include "scene/interiors/furniture_library.h"

#include <filesystem>

#include "scene/obj_reader.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxCatalogueBytes = size_t{4} << 20;
constexpr size_t kMaxImageBytes = size_t{64} << 20;
constexpr size_t kMaxModelBytes = size_t{8} << 20;

}  // namespace

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
