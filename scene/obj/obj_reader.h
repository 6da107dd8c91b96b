// Reads a level from a Wavefront .obj file.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/image/image_loader.h"
#include "scene/model/scene.h"
#include "scene/solid/transmissive.h"

namespace nlg {

struct ObjLevel {
  Scene scene;
  std::vector<std::string> notes;  // what was not found or had to be changed, a line each
};

// y is up and fronts wind counter-clockwise, as programs write them by default: the format itself says neither, nor what a unit
// is. A file has no sky and no lamps.
//
// Geometry   Faces; polygons are cut by their ears (polygon_cut.h). One SceneObject for each object or group. Lines, points and faces of two
//            corners are skipped. Triangles of zero area are dropped and counted.
// Materials  Kd (linear) is the base colour, at most 1; Ke is emission, in cd/m²; d or Tr, below 1, makes a transmissive surface
//            (transmissive.h): Tr is what passes, and where by that no material would stop all light, what is stopped. map_Kd,
//            map_Ke and map_d are images beside them, of the kinds of image_decode.h, with -s, -o and -clamp; map_d by its own
//            opacity if it has one, otherwise by its brightness. An image without a factor counts as it is. Colours of vertices
//            are times Kd. A face whose material was not found is grey, and counted. Of an image that cannot be read half of Kd
//            stands in its place, and nothing shines.
//
// path     the file; its material libraries and their images must lie in its folder or below (findBeside), and may be missing
// unit_m   metres of one unit of the file, finite, above 0
// dense_transmissive   as judgeTransmissive has it; need: of images
// returns  the scene; its id is the file's stem
// throws   InputError naming file, line, expected and got, as obj_text.h says; on positions beyond 1e9 m
ObjLevel readObj(const std::string& path, double unit_m, double dense_transmissive = kDenseTransmissive,
                 ImageNeed need = ImageNeed::all);

// A material library that a file names.
struct ObjLibraryFile {
  std::string path;  // for errors
  std::string key;   // of one library the same, by whatever name it goes: it is read once
  std::function<std::string()> read;
  std::string problem;  // what is noted where there is none, as "is not there"; empty where there is one
  std::string guess;    // FileBeside's
};
using ObjLibrary = std::function<ObjLibraryFile(const std::string& name)>;

// What a file is read with besides its text.
struct ObjFiles {
  ObjLibrary library;
  std::function<ImageBytes(const std::string& name)> image;  // by its name from the file's folder
  SceneBudget* pixels;                                       // of images
  ImageNeed need = ImageNeed::all;
};

// The same of a text in memory, as of an entry of an archive; path is its name in errors.
ObjLevel readObjText(const std::string& path, std::string_view text, double unit_m, const ObjFiles& files,
                     double dense_transmissive = kDenseTransmissive);

}  // namespace nlg
