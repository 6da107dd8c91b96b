// Several lights of one level in one grid: each is that of a bake by itself, and other geometry is refused.
#include "scene/lights/light_sets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/scene_bake.h"
#include "tests/bake/house_corner.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/weights_file/digest_edits.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kDay = "sky=.5,.7,1 sun=40,50,5,4.7,4.1", kNight = "sky=.01,.01,.03 sun=200,20,.05,.05,.1";

struct Settings {
  explicit Settings(const std::vector<std::string>& sets) : table("bake") {
    options.light_rays = 16;
    options.light_error = kLeastLightError;
    options.light_set = sets;
    describe(options, table);
    takeThetaPrecision(&options);
  }
  BakeOptions options = houseCornerOptions();
  OptionTable table;
};

// The light of a grid as it begins, baked with these sets.
Bake bakeOf(const std::vector<std::string>& sets, BakeOptions options = Settings({}).options) {
  options.light_set = sets;
  return bakeOf(PreparedScene("house:3", options), options);
}

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

TEST(LightSetsOfABake, AreEachWhatABakeOfItAloneGives) {
  const Bake both = bakeOf({"day " + kDay, "night " + kNight});
  const Bake day = bakeOf({"day " + kDay}), night = bakeOf({"night " + kNight});
  const LightGrid& grid = both.grid;
  ASSERT_EQ(grid.groups.size(), 2u);
  EXPECT_EQ(grid.groups[0].name, "day");
  EXPECT_EQ(grid.groups[1].name, "night");
  EXPECT_EQ(grid.probe_function, day.grid.probe_function);
  EXPECT_EQ(grid.theta, night.grid.theta);
  // the same light before it is stored; records of two sets may split what packing adds unevenly, and the bake of one adds its own
  const double most = (1.0 + std::sqrt(2.0)) * kLeastLightError;
  EXPECT_LT(differenceOf(grid.groups[0].light, day.grid.light), most);
  EXPECT_LT(differenceOf(grid.groups[1].light, night.grid.light), most);
  EXPECT_GT(differenceOf(grid.groups[1].light, day.grid.light), 0.5) << "night is not day";
  // an engine finds it by day, and the night is what it mixes
  EXPECT_EQ(grid.light, grid.groups[0].light);
  LightGrid mixed = grid;
  ASSERT_TRUE(mixLight({{0.5f, 0.5f, 0.5f}, {2.0f, 2.0f, 2.0f}}, &mixed).ok());
  for (size_t i = 0; i < mixed.light.size(); ++i)
    ASSERT_EQ(mixed.light[i], 0.5f * grid.groups[0].light[i] + 2.0f * grid.groups[1].light[i]);
  // figures of each, those of the first for the grid as it begins
  ASSERT_EQ(both.statistics.light.of_sets.size(), 2u);
  EXPECT_EQ(both.statistics.light.mean, day.statistics.light.mean);
  EXPECT_EQ(both.statistics.light.of_sets[1].second.mean, night.statistics.light.mean);
  EXPECT_EQ(both.statistics.light.of_sets[1].second.error, night.statistics.light.error);
}

TEST(LightSetsOfABake, HoldGroupsOfTheirOwn) {
  const LightGrid grid = bakeOf({"day " + kDay, "night light_groups=kind " + kNight}).grid;
  ASSERT_EQ(grid.groups.size(), 4u);
  EXPECT_EQ(grid.groups[1].name, "night/sky");
  EXPECT_EQ(grid.groups[2].name, "night/sun");
  EXPECT_EQ(grid.groups[3].name, "night/emission");
  std::string bytes;
  ASSERT_TRUE(serializeLightGrid(grid, {ThetaPrecision::int8, kLeastLightError}, {}, &bytes).ok());
  LightGrid read;
  GridMetadata metadata;
  ASSERT_TRUE(parseLightGrid(bytes, &read, &metadata).ok());
  EXPECT_TRUE(metadata.empty());
  for (size_t g = 0; g < 4; ++g) EXPECT_EQ(read.groups[g].begins_dark, g > 0) << g;
  EXPECT_EQ(read.light, grid.groups[0].light);
  const size_t dark = bytes.find("night/sun", bytes.find("light_groups_dark"));
  ASSERT_NE(dark, std::string::npos);
  bytes.replace(dark, 9, "night/son");
  const FileResult refused = parseLightGrid(stamped(bytes), &read, &metadata);
  EXPECT_EQ(refused.status, FileStatus::value_out_of_range);
  EXPECT_NE(refused.detail.find("light_groups_dark"), std::string::npos) << refused.detail;
}

TEST(LightSetsOfABake, AreOfTheSameGeometryAndNotTooMany) {
  BakeOptions options = Settings({"day", "night=house:4"}).options;
  const std::string text = inputErrorOf([&] { loadLitScene("house:3", options); });
  EXPECT_EQ(text.find("house:4: light set night: expected the geometry of house:3"), 0u) << text;
  EXPECT_NE(text.find(", not "), std::string::npos) << text;
  options.light_set.clear();
  for (size_t s = 0; s <= kMaxLightGroups; ++s) {
    if (s == kMaxLightGroups) {
      EXPECT_EQ(loadLitScene("house:3", options).light_sets.size(), kMaxLightGroups);
    }
    options.light_set.push_back("hour_" + std::to_string(s));
  }
  EXPECT_THROW(loadLitScene("house:3", options), UsageError);
}

TEST(LightSetsOfABake, TellWhichSetIsWrong) {
  BakeOptions options;
  const auto lineOf = [&](const std::string& scene, const std::vector<std::string>& sets) {
    options.light_set = sets;
    try {
      loadLitScene(scene, options);
    } catch (const ToolError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(lineOf("house:3", {"day", "night sky=.1"}).find("--light-set night: --sky: expected r,g,b"), 0u);
  // what Blender's exporter multiplied by 683 is told by what shines beside it: by night here, and not by day
  const std::string line = lineOf(NLG_KITCHEN, {"day", "night sun=0"});
  EXPECT_NE(line.find("lamps and suns have another unit in day than in night, where they were divided by 683"), std::string::npos)
      << line;
  EXPECT_EQ(lineOf(NLG_KITCHEN, {"day light_unit=file", "night light_unit=file sun=0"}), "");
  EXPECT_EQ(lineOf(NLG_KITCHEN, {"day sky=.5,.7,1", "night sun=0"}), "");
}

}  // namespace
}  // namespace nlg
