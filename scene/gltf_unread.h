// What a glTF file holds and a scene does not.
#pragma once

#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace nlg {

// One line for each kind of thing: animations, skins, morph targets, points and lines, orthographic cameras, ranges of lamps,
// a light_group that is no text, extensions that are neither read nor known to change nothing here. Images and alpha have their own
// (gltf_looks.h, veils.h).
std::vector<std::string> unreadParts(const tinygltf::Model& model);

}  // namespace nlg
