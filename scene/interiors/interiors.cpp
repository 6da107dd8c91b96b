#include "scene/interiors/interiors.h"

#include <array>
#include <filesystem>
#include <utility>

#include "scene/interiors/plans.h"
#include "scene/procedural/daylight.h"
#include "tool/error.h"

namespace nlg {
namespace {

struct Plan {
  const char* name;
  void (*build)(Home&);
};

constexpr std::array<Plan, 4> kPlans = {
    {{"flat", buildFlat}, {"townhouse", buildTownhouse}, {"office", buildOffice}, {"villa", buildVilla}}};
constexpr uint64_t kHomeStream = 0x686f6d65, kDaylightStream = 0x686f6d65736b79;

// The archive's name as part of a scene's: lower case, letters, digits, - and _ alone.
std::string stemOf(const std::string& path) {
  std::filesystem::path file(path);
  if (!file.has_filename()) file = file.parent_path();
  std::string stem = lowerCase(file.stem().string());
  for (char& c : stem) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    if (!is_plain) c = '-';
  }
  return stem;
}

}  // namespace

const std::vector<std::string>& interiorPlans() {
  static const std::vector<std::string> names = namesOf(kPlans);
  return names;
}

Interior makeInterior(const std::string& path, const std::string& plan, uint64_t seed) {
  for (size_t i = 0; i < kPlans.size(); ++i) {
    if (plan != kPlans[i].name) continue;
    FurnitureLibrary library(path);
    Home home(mixSeed(kHomeStream, i, seed), library);
    kPlans[i].build(home);
    finishShell(home);
    Interior interior;
    interior.scene = home.level.mesh.finish(plan + "_" + std::to_string(seed) + "_" + stemOf(path));
    const Daylight daylight = drawDaylight(mixSeed(kDaylightStream, i, seed));
    interior.scene.light.sky = daylight.sky;
    interior.scene.light.suns = daylight.suns;
    interior.scene.light.lamps = std::move(home.lamps);
    interior.models = {{"placed", library.modelCount()}, {"left out", library.tooFineCount()}};
    return interior;
  }
  std::string names;
  for (const std::string& name : interiorPlans()) names += (names.empty() ? "" : ", ") + name;
  throw UsageError("plan of an interior", "one of " + names, plan);
}

}  // namespace nlg
