// Hostile .obj files with a library of materials: whatever the bytes, they are refused in one line, or become a scene that holds together.
//
// An input is the text of the .obj and that of "square.mtl" beside it, with a zero byte between them.
#include <filesystem>

#include "scene/obj/obj_reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scene_check.h"

namespace nlg::fuzz {
namespace {

// By another name than the .obj gives: composed, and in lower case.
constexpr const char* kLibrary = "\u00e9tage.mtl";

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("scene.obj"), library(kLibrary);
  const size_t end = std::min(bytes.find('\0'), bytes.size());
  file.write(bytes.substr(0, end));
  library.write(bytes.substr(std::min(end + 1, bytes.size())));
  isTaken([] {
    const ObjLevel level = readObj(file.path(), 0.01);
    checkScene(level.scene);
    FUZZ_CHECK(level.notes.size() < 1000, std::to_string(level.notes.size()));
    for (const std::string& note : level.notes) FUZZ_CHECK(note.size() < 4000, note);
  });
}

Seeds seeds() {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\n";
  return {
      {"square", square + "f 1/1 2/2 3/1 4/2\n"},
      {"materials", "mtllib E\u0301TAGE.MTL\n" + square +
                        "o a\nusemtl red\nf 1/1 2/2 3/1\ng b # c\nusemtl \"no such\"\nf -4//1 -2 -1\n" + std::string(1, '\0') +
                        "newmtl red\nKd 1 0 0\nKe xyz 1 2 3\nd -halo .5\nTr 0.5\nTf 1 1 1\nmap_Kd -s 2 2 -o 0.5 0 -clamp on "
                        "C:\\maps\\a.png\nmap_d b%20c.png\nillum 2\n"},
      {"colours", "v 0 0 0 255 0 0\nv 1 0 0 .5 .5 .5\nv 1 1 nan\nv 0 1 0 1\\\n 2 3\nf 1 2 4\nfo 1 2 3\nl 1 2\nxyz\n"},
      {"outline",
       "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nf 1 2 3 4 1 5 6 7 8 5\nf 1 3 2 4 5 8\n"}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
