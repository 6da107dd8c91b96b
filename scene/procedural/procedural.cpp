#include "scene/procedural/procedural.h"

#include <array>

#include "scene/procedural/built_in.h"
#include "scene/procedural/level.h"
#include "tool/error.h"

namespace nlg {
namespace {

struct Family {
  const char* name;
  void (*build)(Level&);
};

constexpr uint64_t kDaylightStream = 0x6c69676874;

constexpr std::array<Family, 11> kFamilies = {{{"house", buildHouse},
                                               {"maze", buildMaze},
                                               {"colonnade", buildColonnade},
                                               {"stairs", buildStairs},
                                               {"clutter", buildClutter},
                                               {"outdoor", buildOutdoor},
                                               {"cave", buildCave},
                                               {"apartment", buildApartment},
                                               {"kitchen", buildKitchen},
                                               {"gallery", buildGallery},
                                               {"meeting", buildMeeting}}};

}  // namespace

const std::vector<std::string>& proceduralFamilies() {
  static const std::vector<std::string> names = namesOf(kFamilies);
  return names;
}

Scene makeProceduralScene(const std::string& family, uint64_t seed) {
  for (size_t i = 0; i < kFamilies.size(); ++i) {
    if (family != kFamilies[i].name) continue;
    Level level(mixSeed(0x6c6576656c, i, seed));
    kFamilies[i].build(level);
    Scene scene = level.mesh.finish(family + "-" + std::to_string(seed));
    const Daylight daylight = drawDaylight(mixSeed(kDaylightStream, i, seed));
    scene.light.sky = daylight.sky;
    scene.light.suns = daylight.suns;
    for (const View& view : level.views) addCamera(scene, view.name, view.eye, view.look, kViewDegrees);
    return scene;
  }
  std::string names;
  for (const Family& known : kFamilies) names += std::string(names.empty() ? "" : ", ") + known.name;
  throw UsageError("scene family", "one of " + names, family);
}

}  // namespace nlg
