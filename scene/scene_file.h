// Opens files of scenes, whole, and only inside the scene's folder.
#pragma once

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

// A file in the scene's folder or below, when all links are followed.
struct FileBeside {
  std::string path;     // empty: there is none
  std::string problem;  // why, to stand behind the address: "is not there", with what else was tried
  std::string guess;    // its name from the folder, where it was found by less than the whole address: else empty
};

// Finds a file by its address, as programs write them: from the scene's folder, with slashes or backslashes, percent-encoded or not. Where
// that leads nowhere, names are compared without regard to case. Of an address of another machine or outside of the folder ("C:\maps\a.png",
// "..\\a.png") the file counts that lies in the folder by the longest end of it ("maps/a.png", "a.png").
// scene_path   the scene's file
FileBeside findBeside(const std::string& scene_path, const std::string& address);
std::string withSlashes(std::string name);  // for backslashes

}  // namespace nlg
