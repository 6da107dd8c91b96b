// Lists what a glTF file holds and a scene does not.
#pragma once

#include <set>
#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace nlg {

// One line for each kind of thing: animations, points and lines, orthographic cameras, ranges of lamps, a light_group that is no text;
// and for each extension that is neither read nor known to change nothing of diffuse light, with the materials, objects and lamps that
// it makes wrong. Images and alpha have their own (gltf_looks.h, transmissive.h).
//
// used_materials   of the scene's triangles
std::vector<std::string> unreadParts(const tinygltf::Model& model, const std::set<int>& used_materials);

}  // namespace nlg
