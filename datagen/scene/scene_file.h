// Files that scenes are read from: whole, and none outside of the scene's folder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace nlg {

inline constexpr uint64_t kMaxSceneFileBytes = (uint64_t{1} << 32) - 1;  // tinygltf and the .glb header count in 32 bits

// The bytes of a file.
// place    what it is to the scene ("file", "buffer"), for errors
// throws   InputError naming the file on what is no file, cannot be read or has 4 GiB or more
std::vector<unsigned char> readSceneFile(const std::string& path, const std::string& place);

// The folder that a scene's file lies in; ".", when its path names none.
std::string folderOf(const std::string& path);

// The path of a file that a scene names, if it lies in the scene's folder or below when all links are followed.
// scene_path   the scene's file; name: relative to its folder; place: for errors
// throws       InputError naming scene and place on a link out of the folder, and on what is no file
std::string fileBeside(const std::string& scene_path, const std::string& name, const std::string& place);

}  // namespace nlg
