// Furniture from archives of Sweet Home 3D: pieces by their use, with models read on demand.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/archive/pk3_archive.h"
#include "scene/interiors/catalogue.h"
#include "scene/interiors/furniture_use.h"
#include "scene/model/scene.h"

namespace nlg {

// A model of furniture, ready to stand in a room: in metres, upright, of its catalogue's size, and not finer than it need be.
//
// The middle of the foot is the origin, y up, the front towards +z. Positions are multiples of 1/1024 m.
//
// Its materials are plain: a mean over the material's area stands in the place of an image, and what lets light through is whole. So
// coarsening loses no colour.
//
// Which faces are evidence of solid is decided by connected component: one that is closed (each edge runs as often one way as the
// other) and whose signed volume is above zero is wound outwards and one-sided; all others are open sheets or inside out, and get
// a double-sided copy of their material. It is decided last, of what stands in the room: a surface that lost faces to coarsening is
// open.
struct FurnitureModel {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> triangle_material;
  std::vector<Material> materials;
};

// Models above the budget are coarsened. Vertices in one cell of a cubic lattice become one at their mean. Triangles that lose their
// area go, and so do those that stand on another in the same sense. Cells grow from 4 mm to a twentieth of the longest side until
// the budget is met.
inline constexpr uint32_t kModelTriangleBudget = 5000;

// model     as obj_reader reads it, in whatever unit
// returns   the model; without triangles when none is left, or when even the coarsest lattice does not meet the budget
FurnitureModel fitFurnitureModel(const Scene& model, const CatalogueEntry& entry);

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

  // The piece's model; null when it is no .obj file of at most 8 MiB, or too fine: counted.
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
