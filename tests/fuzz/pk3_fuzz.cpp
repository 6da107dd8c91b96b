// Hostile .pk3 archives: whatever the bytes, they are refused in one line, or their files can be read, and a level in them with
// its shader scripts and textures.
#include "scene/archive/pk3_archive.h"
#include "scene/quake/bsp_reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scene_check.h"
#include "tests/fuzz/zip_file.h"
#include "tests/scene/image/hand_built_images.h"
#include "tests/scene/quake/hand_built_bsp.h"

namespace nlg::fuzz {
namespace {

constexpr size_t kMaxEntryBytes = size_t{1} << 20;

void readEntries(const std::string& path) {
  const Pk3Archives archives(path);
  for (const std::string& name : archives.names("", "")) {
    FUZZ_CHECK(archives.has(name), name);
    isTaken([&] { FUZZ_CHECK(archives.read(name, kMaxEntryBytes).size() == archives.sizeOf(name), name); });
  }
}

std::string texturedLevel() {
  BspParts parts = smallLevel();
  parts.shaders.push_back({"textures/skies/sky", 4, 0});
  parts.addFace(1, 1, {{0, 0, 90}, {0, 10, 90}, {10, 10, 90}, {10, 0, 90}});
  return parts.bytes();
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("level.pk3");
  file.write(bytes);
  if (!isTaken([] { readEntries(file.path()); })) return;
  isTaken([] { checkScene(readBspFromArchives(file.path(), "m").scene); });
}

Seeds seeds() {
  const std::pair<std::string, std::string> level{"maps/m.bsp", texturedLevel()},
      stone{"textures/test/stone.tga", targa(2, 1, 1, 24, "abc")};
  const std::string script =
      "textures/test/stone { cull none\nq3map_surfacelight 900\n{ map textures/test/stone.tga } }\n"
      "textures/skies/sky { surfaceparm sky\nskyparms env/s 512 -\nq3map_sun 1 1 1 60 30 60\n}\n";
  TemporaryFolder folder;
  return {{"level", zipOf({level, stone, {"scripts/a.shader", script}, {"env/s_up.jpg", jpeg(8, 1, 2, 3)}})},
          {"names", zipOf({{"a.txt", "alpha"}, {"Sub/B.txt", ""}, {"sub/", ""}})},
          {"deflated", fileBytes(writeZip(folder / "a.pk3", {level, stone, {"folder/", ""}}))}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  std::string archive = mutatedTextOrBlindly(std::move(bytes), max_size, random);
  if (random.chance(0.9)) putZipChecksumsRight(&archive);
  return archive;
}

}  // namespace nlg::fuzz
