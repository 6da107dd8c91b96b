// Reads the catalogue of a furniture library of Sweet Home 3D (.sh3f): kind and size of each model.
//
// The format is Java's properties: lines `key#number=value`, one number a piece (www.sweethome3d.com, "Furniture library file
// format"). Only what a house needs is read.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

struct CatalogueEntry {
  std::string name, tags, category;  // UTF-8
  std::string model;                 // path in the archive, without a leading slash
  glm::dvec3 size_m{0.0};            // along x (width), y (height) and z (depth); its front looks towards +z; > 0
  double elevation_m = 0.0;          // of its lowest point above the floor, >= 0
  double top_m = -1.0;               // height of the face that other things stand on, above its lowest point; < 0: none
  // Turns the model upright before it is scaled, row by row; orthonormal and no mirror.
  glm::dmat3 rotation{1.0};
};

// path      of the archive, for errors
// throws    InputError naming the piece on a piece without name, category, model or sizes, on a size that is not in (0, 100] m,
//           an elevation or a top that is not within 100 m, a rotation that is none; naming the line on a broken escape
std::vector<CatalogueEntry> parseCatalogue(const std::string& path, std::string_view text);

}  // namespace nlg
