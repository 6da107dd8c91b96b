#include "scene/interiors/interiors.h"

#include <array>
#include <filesystem>
#include <numeric>
#include <utility>

#include <fmt/ranges.h>

#include "scene/procedural/level.h"
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
  throw UsageError("plan of an interior", fmt::format("one of {}", fmt::join(interiorPlans(), ", ")), plan);
}

double pickFine(Level& level, double low, double high) {
  const int steps = static_cast<int>((high - low) * 100.0 + 0.5);
  return low + 0.01 * level.random.below(static_cast<uint32_t>(steps + 1));
}

std::vector<double> partLength(Level& level, double from, double to, double wall_m, const std::vector<double>& weights) {
  std::vector<double> drawn;
  for (const double weight : weights) drawn.push_back(weight * level.random.uniform(0.88, 1.12));
  const double all = std::accumulate(drawn.begin(), drawn.end(), 0.0);
  const double length = to - from - wall_m * (static_cast<double>(weights.size()) - 1.0);
  std::vector<double> ends;
  double at = from;
  for (size_t i = 0; i < drawn.size(); ++i) {
    const double end = i + 1 == drawn.size() ? to : at + length * drawn[i] / all;
    ends.push_back(at);
    ends.push_back(end);
    at = end + wall_m;
  }
  return ends;
}

void addGroundPlate(Home& home, const Rect& area, double top_m) {
  home.level.mesh.beginObject("ground", Mobility::structure);
  addBox(home.level.mesh, {}, {area.x0, top_m - 1.0, area.z0}, {area.x1, top_m, area.z1}, home.level.palette.ground);
}

}  // namespace nlg
