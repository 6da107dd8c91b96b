// Several states of a level's light in one grid: each is that of a bake by itself, and is added by a relight.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/again/check.h"
#include "bake/again/relight.h"
#include "bake/scene_bake.h"
#include "tests/bake/house_corner.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/weights_file/digest_edits.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

struct Settings {
  explicit Settings(const std::string& state, double of_day = 1.0, const std::string& groups = "one") : table("bake") {
    options.light_rays = 16;
    options.light_error = kLeastLightError;
    options.scene_light.light_state = state;
    options.scene_light.light_groups = groups;
    options.scene_light.sky = {".5", ".7", "1"};
    options.scene_light.sun = {state == "night" ? "200" : "40", "50", "5", "4.7", "4.1"};
    options.scene_light.intensity = of_day;
    describe(options, table);
    takeThetaPrecision(&options);
  }
  Bake bake() const { return bakeOf(PreparedScene("house:3", options), options); }
  BakeOptions options = houseCornerOptions();
  OptionTable table;
};

// Root mean square over probes of the error of irradiance over its light, as what packing may add is counted.
double differenceOf(const std::vector<float>& light, const std::vector<float>& expected) {
  double sum = 0.0;
  size_t count = 0;
  for (size_t first = 0; first < light.size(); first += kShFloats) {
    LightSh difference, of_probe;
    for (size_t i = 0; i < kShFloats; ++i) {
      of_probe[i / 3][static_cast<int>(i % 3)] = expected[first + i];
      difference[i / 3][static_cast<int>(i % 3)] = light[first + i] - expected[first + i];
    }
    if (irradianceSquares(of_probe) == 0.0f) continue;
    sum += irradianceSquares(difference) / irradianceSquares(of_probe);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

class LightStates : public testing::Test {
 protected:
  LightStates() {
    std::filesystem::create_directory(folder_);
    const PreparedScene scene("house:3", day_.options);
    const Bake bake = bakeOf(scene, day_.options);
    BakeRequest request;
    request.out = fileOf("day");
    writeGrid(request, bake.grid, day_.options, bakeMetadata(scene, bakedOptions(day_.table), {}));
  }
  ~LightStates() override { std::filesystem::remove_all(folder_); }

  std::string fileOf(const std::string& name) const { return (folder_ / name).string(); }

  // The grid of `from` with this light, and in what file.
  BakedGrid relit(const std::string& from, const Settings& settings, const std::string& to,
                  const std::string& scene = "house:3") const {
    BakeRequest request;
    request.scene = scene;
    request.relit = fileOf(from);
    request.out = fileOf(to);
    request.out_is_given = true;
    runRelight(request, settings.options, settings.table);
    return readBakedGrid(fileOf(to));
  }

  const std::filesystem::path folder_ = std::filesystem::temp_directory_path() / ("states_" + std::to_string(::getpid()));
  const Settings day_{"day"};
};

TEST_F(LightStates, AreEachWhatABakeOfItAloneGives) {
  const Settings night("night", 0.01);
  const BakedGrid day = readBakedGrid(fileOf("day")), both = relit("day", night, "both");
  const LightGrid& grid = both.grid;
  ASSERT_EQ(grid.groups.size(), 2u);
  EXPECT_EQ(grid.groups[0].name, "day");
  EXPECT_EQ(grid.groups[1].name, "night");
  EXPECT_FALSE(grid.groups[0].begins_dark);
  EXPECT_TRUE(grid.groups[1].begins_dark);
  EXPECT_EQ(grid.theta, day.grid.theta);
  // the same light before it is stored; records of two states may split what packing adds unevenly, and the bake of one adds its own
  const double most = (1.0 + std::sqrt(2.0)) * kLeastLightError;
  EXPECT_LT(differenceOf(grid.groups[0].light, day.grid.light), most);
  EXPECT_LT(differenceOf(grid.groups[1].light, night.bake().grid.light), most);
  EXPECT_GT(differenceOf(grid.groups[1].light, day.grid.light), 0.5) << "night is not day";
  // an engine finds it by day, and the night is what it mixes
  EXPECT_EQ(grid.light, grid.groups[0].light);
  LightGrid mixed = grid;
  ASSERT_TRUE(mixLight({{0.5f, 0.5f, 0.5f}, {2.0f, 2.0f, 2.0f}}, &mixed).ok());
  for (size_t i = 0; i < mixed.light.size(); ++i)
    ASSERT_EQ(mixed.light[i], 0.5f * grid.groups[0].light[i] + 2.0f * grid.groups[1].light[i]);
  // it is fresh as long as the day is
  const SceneSource source = loadLitScene("house:3", day_.options);
  EXPECT_EQ(changesSince("both", both, source, day_.table, {}), std::vector<std::string>{});
}

TEST_F(LightStates, HoldGroupsOfTheirOwn) {
  relit("day", Settings("night", 0.01, "kind"), "both");
  std::string bytes = readFile(fileOf("both"));
  LightGrid read;
  GridMetadata metadata;
  ASSERT_TRUE(parseLightGrid(bytes, &read, &metadata).ok());
  std::vector<std::string> names;
  for (const LightGroup& group : read.groups) {
    EXPECT_EQ(group.begins_dark, !names.empty()) << group.name;
    names.push_back(group.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"day", "night/sky", "night/sun", "night/emission"}));
  EXPECT_EQ(read.light, read.groups[0].light);
  const size_t dark = bytes.find("night/sun", bytes.find("light_groups_dark"));
  ASSERT_NE(dark, std::string::npos);
  bytes.replace(dark, 9, "night/son");
  const FileResult refused = parseLightGrid(stamped(bytes), &read, &metadata);
  EXPECT_EQ(refused.status, FileStatus::value_out_of_range);
  EXPECT_NE(refused.detail.find("light_groups_dark"), std::string::npos) << refused.detail;
}

TEST_F(LightStates, AreAddedOnlyToWhatHasANameForItsOwn) {
  const auto refusalOf = [&](const std::string& from, const Settings& settings, const std::string& scene = "house:3") {
    return inputErrorOf([&] { relit(from, settings, "refused", scene); });
  };
  // of the same state it is a relight
  const BakedGrid darker = relit("day", Settings("day", 0.5), "darker");
  EXPECT_EQ(darker.grid.groups.size(), 1u);
  EXPECT_FALSE(darker.grid.groups[0].begins_dark);
  EXPECT_NE(refusalOf("day", Settings("night"), "house:4").find("geometry"), std::string::npos);
  relit("day", Settings("night"), "both");
  EXPECT_EQ(relit("both", Settings("dusk"), "three").grid.groups.size(), 3u);
  for (const char* state : {"", "day", "night"})
    EXPECT_NE(refusalOf("both", Settings(state)).find("light_state"), std::string::npos) << state;
  relit("day", Settings(""), "nameless");
  EXPECT_NE(refusalOf("nameless", Settings("night")).find("light_state"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(fileOf("refused")));
  Settings thin("night");
  thin.options.thin_error = 0.1;
  EXPECT_THROW(relit("day", thin, "refused"), UsageError);
}

}  // namespace
}  // namespace nlg
