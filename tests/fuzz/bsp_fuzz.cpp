// Hostile levels of Quake III: whatever the bytes, they are refused in one line, or become a scene that holds together.
#include "scene/quake/bsp_reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scene_check.h"
#include "tests/scene/quake/hand_built_bsp.h"

namespace nlg::fuzz {

void readOne(std::string_view bytes) {
  static const ScratchFile file("level.bsp");
  file.write(bytes);
  isTaken([] { checkScene(readBsp(file.path()).scene); });
}

Seeds seeds() {
  BspParts lit = smallLevel();
  lit.lightVertex(0, {0.5f, 0.5f}, 10, 20, 30);
  lit.models[0].max = {200.0f, 100.0f, 100.0f};
  lit.entities = R"({ "classname" "worldspawn" } { "classname" "light" "origin" "10 20 30" }
{ "classname" "func_door" "model" "*1" "origin" "8 8 8" } { "classname" "info_player_start" "origin" "0 0 0" })";
  lit.shaders.push_back({"textures/skies/sky", 4, 0});
  lit.beginModel();
  lit.addFace(0, 3, {{0, 0, 50}, {0, 10, 50}, {10, 10, 50}, {10, 0, 50}});
  lit.addFace(1, 1, {{0, 0, 90}, {0, 10, 90}, {10, 10, 90}, {10, 0, 90}});
  return {{"small", smallLevel().bytes()}, {"lit", lit.bytes()}};
}

std::string mutated(std::string bytes, size_t max_size, Random&) { return mutatedBlindly(std::move(bytes), max_size); }

}  // namespace nlg::fuzz
