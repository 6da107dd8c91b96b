// Furniture from archives of Sweet Home 3D: pieces by their use, models read when they are first asked for.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/interiors/catalogue.h"
#include "scene/interiors/furniture_model.h"
#include "scene/interiors/furniture_use.h"
#include "scene/pk3_archive.h"

namespace nlg {

class FurnitureLibrary {
 public:
  // path     a .sh3f file, or a folder: all its .sh3f files in alphabetical order
  // throws   InputError on: no such file, a folder without archives; what Pk3Archives and parseCatalogue refuse; an archive
  //          without PluginFurnitureCatalog.properties, with no piece, or one of more than 4 MiB
  explicit FurnitureLibrary(const std::string& path);

  // Pieces of a use in the catalogues' order; indices below size().
  const std::vector<size_t>& pieces(FurnitureUse use) const;
  const CatalogueEntry& entry(size_t piece) const { return pieces_.at(piece).entry; }
  size_t size() const { return pieces_.size(); }

  // The piece's model; null when it is no .obj file of at most 8 MiB, or too fine (furniture_model.h): counted.
  // throws   InputError on what readObjText refuses, and on a model that is not in the archive
  const FurnitureModel* model(size_t piece);

  uint32_t tooFineCount() const { return too_fine_count_; }  // models that were asked for and not given
  uint32_t modelCount() const { return model_count_; }       // models that were given

 private:
  struct Piece {
    CatalogueEntry entry;
    size_t archive_idx = 0;
    std::optional<FurnitureModel> model;  // once it was asked for
  };

  void addArchive(const std::string& file);
  FurnitureModel read(const Piece& piece);

  SceneBudget pixels_ = SceneBudgets().pixels;      // of all models' images together
  SceneBudget unpacked_ = SceneBudgets().unpacked;  // of all archives together
  std::vector<std::unique_ptr<Pk3Archives>> archives_;
  std::vector<Piece> pieces_;
  std::map<FurnitureUse, std::vector<size_t>> by_use_;
  uint32_t too_fine_count_ = 0, model_count_ = 0;
};

}  // namespace nlg
