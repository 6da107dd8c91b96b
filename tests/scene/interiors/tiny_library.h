// A furniture library that fits into a test: closed boxes for pieces, and what is wrong with models of the wild.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/scene/quake/hand_built_bsp.h"

namespace nlg {

// An axis-aligned cube of side 2 around the origin, wound outwards.
inline std::string cubeObj() {
  return "mtllib looks.mtl\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nusemtl red\n"
         "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";
}

struct TinyPiece {
  std::string category, name;
  double width_cm, depth_cm, height_cm;
  std::string more = "";  // further lines, # in the place of the number
  std::string model = "cube.obj";
};

inline std::string tinyCatalogue(const std::vector<TinyPiece>& pieces) {
  std::string text = "id=test\nname=Test\n";
  for (size_t i = 0; i < pieces.size(); ++i) {
    const std::string number = "#" + std::to_string(i + 1);
    const TinyPiece& piece = pieces[i];
    text += "name" + number + "=" + piece.name + "\ncategory" + number + "=" + piece.category + "\nmodel" + number + "=/models/" +
            piece.model + "\nwidth" + number + "=" + std::to_string(piece.width_cm) + "\ndepth" + number + "=" +
            std::to_string(piece.depth_cm) + "\nheight" + number + "=" + std::to_string(piece.height_cm) + "\n";
    for (const char c : piece.more) text += c == '#' ? number : std::string(1, c);
  }
  return text;
}

inline std::vector<TinyPiece> tinyPieces() {
  return {{"Bedroom", "Bed", 160, 205, 60},
          {"Bedroom", "Wardrobe", 150, 60, 200},
          {"Bedroom", "Bedside table", 45, 40, 45},
          {"Living room", "Sofa", 190, 85, 80},
          {"Living room", "Coffee table", 110, 60, 45},
          {"Living room", "Table", 160, 90, 75},
          {"Living room", "Chair", 45, 50, 90},
          {"Living room", "Bookcase", 120, 35, 190},
          {"Living room", "Plant", 60, 60, 100, "tags#=Patio\n"},
          {"Kitchen", "Refrigerator", 60, 60, 170},
          {"Kitchen", "Cup", 8, 8, 10},
          {"Office", "Desk", 140, 70, 73},
          {"Office", "Chair", 60, 60, 100, "tags#=Seat\n"},
          {"Lights", "Hanging light", 40, 40, 60, "tags#=Pendant\nelevation#=180\n"},
          {"Characters", "Male", 60, 40, 180, "tags#=Human\n"},
          {"Exterior", "Bench", 150, 50, 80, "tags#=Outdoor\n"},
          {"Doors and windows", "Exterior door", 95, 18, 205, "doorOrWindow#=true\n"}};
}

// Writes the library; returns its path.
inline std::string writeTinyLibrary(const TemporaryFolder& folder, const std::vector<TinyPiece>& pieces = tinyPieces(),
                                    const std::vector<std::pair<std::string, std::string>>& more_files = {}) {
  std::vector<std::pair<std::string, std::string>> files = {{"PluginFurnitureCatalog.properties", tinyCatalogue(pieces)},
                                                            {"models/cube.obj", cubeObj()},
                                                            {"models/looks.mtl", "newmtl red\nKd 0.5 0.1 0.1\n"}};
  files.insert(files.end(), more_files.begin(), more_files.end());
  return writeZip(folder / "Tiny.sh3f", files);
}

}  // namespace nlg
