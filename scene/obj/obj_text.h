// Parses the records of .obj and .mtl files.
//
// Keywords count in any case, a byte order mark is passed by, a backslash at a line's end continues it, "# …" ends a line of numbers.
// Words that say nothing of surfaces' places and diffuse light (normals, smoothing, points, lines, highlights, bumps) are passed by; all
// others that are not read are counted by name.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

using UnreadWords = std::map<std::string, uint64_t>;  // in lower case, with how often they came

struct ObjCorner {
  static constexpr uint32_t kNowhere = 0xffffffff;
  uint32_t vertex = 0;  // beyond those of the file: none
  int32_t place = -1;   // on images; -1, or beyond those of the file: none
};

struct ObjFace {
  uint32_t first_corner = 0, corner_count = 0;  // 3 … 8,192
  int32_t material = -1;                        // of material_names; -1: none was named
  uint32_t line = 0;
};

struct ObjShape {
  std::string name;
  uint32_t first_face = 0;
};

struct ObjRecords {
  std::vector<glm::dvec3> positions;  // in the file's unit; NaN where a line has not three numbers of -1e30 to 1e30
  std::vector<glm::vec3> colours;     // empty, or of each position, as written; NaN where it has none
  std::vector<glm::dvec2> places;     // NaN where a line has no numbers
  std::vector<ObjCorner> corners;
  std::vector<ObjFace> faces;
  std::vector<ObjShape> shapes;  // objects and groups; at least one, and none but the last without faces
  std::vector<std::string> material_names;
  std::vector<std::string> libraries;  // lines as they are: mtllib, one name or several
  uint64_t faces_of_two_corners = 0;   // or of fewer: left out
  UnreadWords unread;
};

// throws   InputError naming the line on bytes that are no text, a face
//          of more than 8,192 corners, more than 2^27 vertices, or more triangles than one scene may have (scene_file.h)
ObjRecords readObjRecords(const std::string& path, std::string_view text);

// An image, and how it lies on places: from the lower left corner, times scale, plus offset.
struct MtlImage {
  std::string name;  // with slashes; empty: none
  glm::dvec2 scale{1.0}, offset{0.0};
  bool clamp = false;
};

struct MtlMaterial {
  std::string name;                         // its words, one blank between them
  std::optional<glm::dvec3> colour, shine;  // Kd and Ke, 0 … 1e12
  std::optional<double> stops, passes;      // d and Tr, 0 … 1
  MtlImage colour_image, shine_image, stops_image;
};

// A value that is none (a colour out of range, an opacity of 7) counts among the words that are not read.
// throws   InputError on bytes that are no text
std::vector<MtlMaterial> readMtlRecords(const std::string& path, std::string_view text, UnreadWords* unread);

// The line's words, parted by blanks; and what stands from one of them to the end of another.
std::vector<std::string_view> wordsOf(std::string_view line);
std::string namedBy(std::string_view first, std::string_view last);

}  // namespace nlg
