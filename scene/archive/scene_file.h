// Opens files of scenes, whole, and only inside the scene's folder, and limits what reading may take.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/model/oddities.h"

namespace nlg {

// Limits what reading one scene may take, so that a small file cannot exhaust the machine.
//
// Files pack: a byte of an archive holds a thousand, a scan of an image a few bytes that ask for all its pixels again, an accessor
// of glTF as many zeros as it says. Each budget is of a whole scene, however many files and entries it is made of, and far above
// all levels that we know (docs/guide/scenes.md has the largest of each).

inline constexpr uint64_t kMaxSceneTriangles = uint64_t{1} << 25;  // of a glTF or .obj file, instances counted each
inline constexpr uint64_t kMaxLevelTriangles = uint64_t{1} << 23;  // of a Quake III level, patches cut into triangles
inline constexpr uint64_t kMaxSceneBytes =
    (uint64_t{1} << 32) - 1;                                      // a glTF or .obj file, the files it names, what they unpack to
inline constexpr uint64_t kMaxUnpackedBytes = uint64_t{1} << 30;  // that archives (.pk3, .sh3f) unpack to
inline constexpr uint64_t kMaxImagePixels = uint64_t{1} << 33;    // of textures, times the scans of each behind the 16th
inline constexpr uint64_t kMaxTexels = uint64_t{1} << 26;  // kept of all images: beyond it each is kept smaller, none is refused
inline constexpr uint64_t kLeastScanPixels = 4096;         // as which a smaller scan counts: beginning one takes time, too
inline constexpr uint64_t kMaxAccessorElements = uint64_t{1} << 27;  // that the primitives of glTF read: corners, sparse values
inline constexpr uint64_t kMaxAccessorZeros = uint64_t{1} << 20;     // of these, in accessors without a buffer view

// One of them, as it is spent.
class SceneBudget {
 public:
  // what   its unit, as errors name it: "triangles"
  SceneBudget(const char* what, uint64_t most) : what_(what), most_(most) {}

  // throws   BudgetError naming the budget, what is asked of it so far, and the place, when that is more than there was
  void take(uint64_t amount, const std::string& path, const std::string& place);
  // The same, and nothing is spent: of what may be asked for at most.
  void require(uint64_t amount, const std::string& path, const std::string& place) const;
  uint64_t left() const { return most_ - taken_; }

 private:
  const char* what_;
  uint64_t most_, taken_ = 0;
};

// All of them, whole: what one scene's reader starts with.
struct SceneBudgets {
  SceneBudget triangles{"triangles", kMaxSceneTriangles};
  SceneBudget level_triangles{"triangles of a level", kMaxLevelTriangles};
  SceneBudget bytes{"bytes of files and what they unpack to", kMaxSceneBytes};
  SceneBudget unpacked{"bytes out of archives", kMaxUnpackedBytes};
  SceneBudget pixels{"pixels of textures, times their scans,", kMaxImagePixels};
  SceneBudget accessor_elements{"elements of accessors", kMaxAccessorElements};
  SceneBudget accessor_zeros{"elements of accessors without a buffer view", kMaxAccessorZeros};
};

// All of them in words: what --help of every tool that reads scenes ends with.
std::string sceneBudgets();

// The bytes of a regular file.
// place        what it is to the scene ("file", "buffer"), for errors
// bytes_left   of kMaxSceneBytes: of all that the scene is read from
// throws       InputError naming the file on one that cannot be opened or read, and on one too many bytes
std::vector<unsigned char> readSceneFile(const std::string& path, const std::string& place, SceneBudget& bytes_left);

// The folder that a scene's file lies in; ".", when its path names none.
std::string folderOf(const std::string& path);

// A file in the scene's folder or below. Its links may lead anywhere in the repository that the folder is in (.git, .dvc), and out of it into
// stores of git-annex and DVC alone. Of a scene that is a link itself the folder counts in which its file lies, too.
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
std::string percentDecoded(const std::string& text);

}  // namespace nlg
