// Files that scenes are read from: whole, and none outside of the scene's folder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene_budget.h"

namespace nlg {

// The bytes of a regular file.
// place        what it is to the scene ("file", "buffer"), for errors
// bytes_left   of kMaxSceneBytes: of all that the scene is read from
// throws       InputError naming the file on one that cannot be opened or read, and on one too many bytes
std::vector<unsigned char> readSceneFile(const std::string& path, const std::string& place, SceneBudget& bytes_left);

// The folder that a scene's file lies in; ".", when its path names none.
std::string folderOf(const std::string& path);

// Whether nothing is there by a name that fileBeside takes. Noted as an input: it may come yet.
bool isMissingBeside(const std::string& scene_path, const std::string& name);

// The path of a file that a scene names, if it lies in the scene's folder or below when all links are followed.
// scene_path   the scene's file; name: relative to its folder; place: for errors
// throws       InputError naming scene and place on a link out of the folder, and on what is no regular file
std::string fileBeside(const std::string& scene_path, const std::string& name, const std::string& place);

}  // namespace nlg
