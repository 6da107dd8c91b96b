// Bakes that are to end in time: what they leave out, and that they leave out nothing where there is time enough.
#include "bake/bake_in_time.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/bake/house_corner.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/error.h"

namespace nlg {
namespace {

const BakeCosts kCosts{{10.0, 2.0}, 8.0, 1.0};  // 21 s

TEST(InTime, LeavesOutNothingThatThereIsTimeFor) {
  const BakeOptions asked;
  EXPECT_EQ(leftOutText(asked, inTime(asked, kCosts, 21.0)), "");
}

TEST(InTime, LeavesOutWhatCostsLeastFirst) {
  const BakeOptions asked;
  const auto leftOut = [&](double left_s) { return leftOutText(asked, inTime(asked, kCosts, left_s)); };
  EXPECT_EQ(leftOut(20.9), "no short fits");
  EXPECT_EQ(leftOut(19.0), "no short fits");
  EXPECT_EQ(leftOut(18.9), "32 rays a place, no short fits");
  EXPECT_EQ(leftOut(14.9), "16 rays a place, no short fits");
  EXPECT_EQ(leftOut(0.0), "16 rays a place, no short fits");
}

TEST(InTime, KeepsFewerRaysThatWereAskedFor) {
  BakeOptions asked;
  asked.light_rays = 8;
  EXPECT_EQ(inTime(asked, kCosts, 0.0).light_rays, 8);
}

// What is done costs no more: of light's 9 s all are there.
TEST(InTime, LeavesWhatIsDoneAsItIs) {
  const BakeOptions asked;
  const BakeCosts left{{}, 8.0, 1.0};
  EXPECT_EQ(leftOutText(asked, inTime(asked, left, 9.0)), "");
  EXPECT_EQ(leftOutText(asked, inTime(asked, left, 4.0)), "16 rays a place");
}

std::vector<Generator> generators() {
  std::vector<Generator> generators;
  generators.emplace_back(sampleGenerator({RepresentationKind::tent_mlp4}, 24, 3, 1));
  return generators;
}

BakeOptions corner() {
  BakeOptions options = houseCornerOptions(1);
  takeThetaPrecision(&options);
  return options;
}

std::string spoolFolder() { return std::filesystem::temp_directory_path().string(); }

TEST(BakeInTime, MakesTheWholeGridWhereThereIsTimeEnough) {
  BakeOptions options = corner();
  options.thin_error = 0.1;
  auto scene = std::make_unique<BakeScene>("house:3", options);
  const LightGrid whole = bakeScene(*scene, generators(), options, spoolFolder()).grid;
  const BakedInTime baked = bakeInTime(&scene, generators(), options, spoolFolder(), [] { return 1e9; });
  EXPECT_EQ(leftOutText(options, baked.chosen.options), "");
  EXPECT_FALSE(baked.chosen.is_coarsest);
  EXPECT_EQ(baked.bake.grid.theta, whole.theta);
  EXPECT_EQ(baked.bake.grid.light, whole.light);
}

TEST(BakeInTime, LeavesOutRefinementAndRaysThatItHasNoTimeForAnyMore) {
  BakeOptions options = corner();
  options.light_set = {"day sky=1,1,1", "night sky=0.1,0.1,0.1"};
  auto scene = std::make_unique<BakeScene>("house:3", options);
  int asked = 0;  // of probes' distance, then of all else: later everything has taken too long
  const BakedInTime baked = bakeInTime(&scene, generators(), options, spoolFolder(), [&] { return ++asked <= 2 ? 1e9 : 0.0; });
  EXPECT_EQ(leftOutText(options, baked.chosen.options), "16 rays a place, some functions less refined");
  EXPECT_FALSE(baked.chosen.is_coarsest);
  EXPECT_EQ(baked.bake.statistics.light.rays_per_place, 16u);
  EXPECT_EQ(baked.bake.statistics.light.of_sets.size(), 2u);
  EXPECT_GT(baked.bake.statistics.left_for_time, 0u);
  EXPECT_EQ(baked.bake.statistics.refined(), 0u);
  EXPECT_TRUE(checkLightGrid(baked.bake.grid).ok());
}

// Where there is no time at all there is a grid nevertheless, and it has light.
TEST(BakeInTime, IsAsCoarseAsItCanBeWhereNoTimeIsEnough) {
  const BakeOptions options = corner();
  auto scene = std::make_unique<BakeScene>("house:3", options);
  const uint64_t probes = scene->tree.probeCount();
  const BakedInTime baked = bakeInTime(&scene, generators(), options, spoolFolder(), [] { return 0.0; });
  EXPECT_TRUE(baked.chosen.is_coarsest);
  EXPECT_EQ(baked.chosen.options.spacing_m, kMostCoarser * options.spacing_m);
  EXPECT_EQ(leftOutText(options, baked.chosen.options).find("probes 6 m apart, 16 rays a place, no short fits"), 0u);
  EXPECT_LT(baked.bake.grid.tree.probeCount(), probes);
  EXPECT_GT(baked.bake.statistics.light.mean, 0.0);
  EXPECT_FALSE(baked.bake.grid.light.empty());
}

// The grid says what it was made with: such a bake makes it again.
TEST(BakeInTime, MakesWhatABakeWithTheChosenSettingsMakes) {
  const BakeOptions options = corner();
  auto scene = std::make_unique<BakeScene>("house:3", options);
  const BakedInTime baked = bakeInTime(&scene, generators(), options, spoolFolder(), [] { return 0.0; });
  BakeOptions chosen = baked.chosen.options;
  EXPECT_EQ(chosen.max_seconds, 0.0);
  const LightGrid again = bakeScene(BakeScene("house:3", chosen), generators(), chosen, spoolFolder()).grid;
  EXPECT_EQ(baked.bake.grid.theta, again.theta);
  EXPECT_EQ(baked.bake.grid.light, again.light);
}

TEST(BakeInTime, IsNoOtherBake) {
  BakeOptions options = corner();
  options.max_seconds = 100.0;
  EXPECT_THROW(bakeScene(BakeScene("house:3", options), generators(), options, spoolFolder()), UsageError);
}

TEST(BakeInTime, RefusesWhatTakesNobodyKnowsHowLong) {
  BakeOptions bytes, shares, point, thin;
  bytes.max_bytes = 1e5;
  shares.share_rmse = 0.005;
  point.light = "point";
  for (const BakeOptions& options : {bytes, shares, point}) EXPECT_THROW(requireKnownTimes(options), UsageError);
  thin.thin_error = 0.03;
  EXPECT_NO_THROW(requireKnownTimes(thin));
}

TEST(LightInTime, LeavesOutRaysAndThenPlaces) {
  BakeOptions options = corner();
  options.spacing_m = 1.0;
  options.light_places = 64;  // else a scene so small had more than it asks for
  auto scene = std::make_unique<BakeScene>("house:3", options);
  const LightGrid grid = bakeScene(*scene, generators(), options, spoolFolder()).grid;
  const size_t places = scene->air.places.size();
  const auto chosenIn = [&](double left_s) { return chooseLightInTime(&scene, {}, grid, options, [&] { return left_s; }); };
  EXPECT_EQ(leftOutText(options, chosenIn(1e9).options), "");
  EXPECT_EQ(scene->air.places.size(), places);
  const ChosenInTime none = chosenIn(0.0);
  EXPECT_EQ(leftOutText(options, none.options), "4 places a cell, 16 rays a place");
  EXPECT_TRUE(none.is_coarsest);
  EXPECT_LT(scene->air.places.size(), places);
}

}  // namespace
}  // namespace nlg
