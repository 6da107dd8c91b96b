// What a check says of a grid that was baked of something else.
#include "bake/again/check.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bake/scene_bake.h"
#include "tests/bake/house_corner.h"
#include "tool/error.h"

namespace nlg {
namespace {

// A corner of a house under a sun.
struct Settings {
  Settings() : table("bake") {
    options.light_rays = 16;
    describe(options, table);
    takeThetaPrecision(&options);
  }
  BakeOptions options = houseCornerOptions();
  OptionTable table;
};

std::string bytesOf(const LightGrid& grid, const GridMetadata& metadata, const BakeOptions& options) {
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {options.policy.theta_precision, options.light_error}, metadata, &bytes);
  EXPECT_TRUE(result.ok()) << result.detail;
  return bytes;
}

// The bytes of a whole bake's file.
std::string bakedBytes(const std::string& request, const Settings& settings) {
  const PreparedScene scene(request, settings.options);
  return bytesOf(bakeOf(scene, settings.options).grid,
                 bakeMetadata(scene, bakedOptions(settings.table), {{"weights of tent_mlp4", "00ff"}}), settings.options);
}

BakedGrid parsed(const std::string& bytes) {
  BakedGrid baked;
  EXPECT_TRUE(parseLightGrid(bytes, &baked.grid, &baked.metadata).ok());
  return baked;
}

TEST(ChangesSince, NameWhatABakeWouldDoOtherwise) {
  const Settings settings;
  const BakedGrid baked = parsed(bakedBytes("house:3", settings));
  const std::map<std::string, std::string> weights = {{"weights of tent_mlp4", "00ff"}};
  const auto changesOf = [&](const std::string& request, const Settings& now, const std::map<std::string, std::string>& of) {
    return changesSince("grid", baked, loadLitScene(request, now.options), now.table, of);
  };
  using Changes = std::vector<std::string>;
  EXPECT_EQ(changesOf("house:3", settings, weights), Changes{});
  EXPECT_EQ(changesOf("house:4", settings, weights), Changes{"geometry changed"});
  EXPECT_EQ(changesOf("house:3", settings, {{"weights of tent_mlp4", "00fe"}}), Changes{"weights changed"});
  Settings dusk;
  dusk.options.scene_light.sun = {"200", "10", "3", "2", "1"};
  const Changes changes = changesOf("house:3", dusk, weights);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0], "light changed");
  EXPECT_EQ(changes[1].find("setting changed: sun from []"), 0u) << changes[1];
  Settings grouped;
  grouped.options.scene_light.light_groups = "kind";
  EXPECT_EQ(changesOf("house:3", grouped, weights),
            (Changes{"groups of light changed", "setting changed: light_groups from \"one\" to \"kind\""}));
}

TEST(ChangesSince, TellLightFromItsGroups) {
  Settings settings;
  settings.options.scene_light.light_groups = "name";
  const BakedGrid baked = parsed(bakedBytes("house:3", settings));
  SceneSource source = loadLitScene("house:3", settings.options);
  const auto changes = [&] { return changesSince("grid", baked, source, settings.table, {{"weights of tent_mlp4", "00ff"}}); };
  using Changes = std::vector<std::string>;
  ASSERT_EQ(changes(), Changes{});
  ASSERT_FALSE(source.scene.light.groups.names.empty());
  source.scene.light.groups.names[0] = "a name that its author thought better of";
  EXPECT_EQ(changes(), Changes{"groups of light changed"});
  source.scene.light.sky.zenith += 1.0f;
  EXPECT_EQ(changes(), Changes{"light changed"});
}

}  // namespace
}  // namespace nlg
