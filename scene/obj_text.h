// The lines of .obj and .mtl files that the reader needs, checked before tinyobjloader reads them.
//
// tinyobjloader takes a number that it cannot read for 0 and leaves faces out that name vertices which do not exist. Both are
// refused here, by line. Lines of other kinds (points, curves, smoothing groups, subdivision tags, textures other than those of colour and opacity) are left out,
// continued lines are joined, and a material's name of several words becomes one word. Faces of one or two corners, which
// modellers leave behind, are left out and counted.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace nlg {

struct ObjText {
  std::string lines;                  // for tinyobjloader
  uint64_t faces_of_two_corners = 0;  // or of fewer
};

// throws   InputError naming the line on bytes that are no text, a position that is not three numbers of -1e30 to 1e30, a face
//          of more than 1,024 corners, a corner that is no index of an earlier vertex, more than 2^27 vertices, or more triangles
//          than one scene may have (scene_budget.h)
ObjText checkedObjText(const std::string& path, std::string_view text);

// A line for opacity (d, Tr) that is not one number of 0 to 1 is left out, too.
// throws   InputError naming the line on colours (Kd, Ke) that are not three numbers of 0 to 1e12
std::string checkedMtlText(const std::string& path, std::string_view text);

}  // namespace nlg
