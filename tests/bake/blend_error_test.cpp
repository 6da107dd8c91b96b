// Holes, leaks and shares of a sheet of which everything is known, under functions that are right, or wrong on purpose.
#include "bake/blend_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "bake/scene_functions.h"
#include "tests/bake/house_corner.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

// Between probes at 0 and at 1.
constexpr float kSheetX = 0.5f;

// Thinner than any wall, from edge_y on and wider than all supports else; air on both sides.
Scene sheetFrom(float edge_y) {
  constexpr float kEnd = 5.0f;
  SceneOfFaces faces;
  faces.addQuad({kSheetX, edge_y, -kEnd}, {kSheetX, kEnd, -kEnd}, {kSheetX, kEnd, kEnd}, {kSheetX, edge_y, kEnd}, Sides::two);
  return faces.finish();
}
Scene sheet() { return sheetFrom(-5.0f); }

// Probes at every metre of the world.
BakeOptions metreOptions() {
  BakeOptions options;
  options.spacing_m = 1.0;
  options.density_growth = 0.0;
  options.align_lattice = true;
  options.extent_m = {"-2", "-2", "-2", "2", "2", "2"};
  return options;
}

SceneSource sourceOf(Scene scene) {
  SceneSource source;
  source.scene = std::move(scene);
  return source;
}

// All that a bake has before it makes theta.
struct Seen {
  explicit Seen(SceneSource source, const BakeOptions& options, int threads = 2)
      : scene(std::move(source), options),
        targets(scene, options.seed, threads),
        functions(scene, options, threads, std::filesystem::temp_directory_path().string()) {
    functions.tellTargets(&targets);
    functions.makeAll([](int) { return [](const FunctionRows&) { return [] {}; }; });
  }
  PreparedScene scene;
  BlendTargets targets;
  SceneFunctions functions;
};

// What stands for the function of a probe in a grid of the test's own.
enum class Stands { exactly, bare_tent, zero };

class SheetBlends : public testing::Test {
 protected:
  // Of probes before the sheet (x <= 0) and behind it. All others are bare tents.
  BlendErrors errorsOf(Stands before, Stands behind) const {
    LightGrid grid;
    grid.tree = seen_.scene.treeInWorld();
    grid.representations = {{RepresentationKind::tent_mlp4}};
    for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
      const double x = grid.tree.probePosition(probe)[0];
      const bool is_before = std::abs(x) < 1e-6, is_behind = std::abs(x - 1.0) < 1e-6;
      const Stands stands = is_before ? before : is_behind ? behind : Stands::bare_tent;
      grid.probe_function.push_back(stands == Stands::bare_tent ? kFreeSpace : grid.addFunction(0, theta(x, stands).data()));
    }
    const FileResult checked = checkLightGrid(grid);
    EXPECT_TRUE(checked.ok()) << checked.detail;
    return blendErrors(seen_.targets, grid);
  }

 private:
  // sigmoid(steep (x - sheet)), LeakyReLU of which is as steep as to be 0 or 1 from a millimetre on.
  static std::vector<float> theta(double probe_x, Stands stands) {
    constexpr NetworkShape kShape = {4, 0, OutputFunction::sigmoid};
    const float steep = probe_x < kSheetX ? -1e6f : 1e6f;
    std::vector<float> theta(kShape.thetaCount(), 0.0f);
    if (stands == Stands::zero) {
      theta[kShape.b3()] = -100.0f;
      return theta;
    }
    theta[kShape.w1()] = steep;
    theta[kShape.b1()] = steep * (static_cast<float>(probe_x) - kSheetX);
    theta[kShape.w3()] = 1.0f;
    return theta;
  }

  const Seen seen_{sourceOf(sheet()), metreOptions()};
};

TEST_F(SheetBlends, ExactFunctionsHaveNoHolesAndNoLeaks) {
  for (const BlendFigures& figures : errorsOf(Stands::exactly, Stands::exactly)) {
    EXPECT_GT(figures.points, kBlendSurfacePoints / 4);
    EXPECT_EQ(figures.holes, 0.0);
    EXPECT_EQ(figures.leaks, 0.0);
    // floats of a few weights
    EXPECT_NEAR(figures.total_variation, 0.0, 1e-5);
  }
}

TEST_F(SheetBlends, BareTentsLeakByWhatTheyHoldBehindTheSheet) {
  const BlendErrors errors = errorsOf(Stands::bare_tent, Stands::bare_tent);
  for (size_t c = 1; c < kBlendClassCount; ++c) {
    EXPECT_EQ(errors[c].holes, 0.0);
    EXPECT_EQ(errors[c].leaks, 1.0) << "half of all weight, and at 20 cm still .3, is of probes that do not see the point";
    // that share is the tent's, .5 less the distance
    EXPECT_GE(errors[c].total_variation, 0.5 - kBlendBordersM[c]);
    EXPECT_LE(errors[c].total_variation, 0.5 - kBlendBordersM[c - 1]);
  }
  // nearer than 30 cm are .6 of one of four columns of cells; of 2,000 points seven deviations are .056
  EXPECT_NEAR(errors[0].leaks, 0.6 / 4.0, 0.056);
}

TEST_F(SheetBlends, FunctionsOfZeroAreHoles) {
  const BlendErrors errors = errorsOf(Stands::zero, Stands::zero);
  for (size_t c = 1; c < kBlendClassCount; ++c) {
    EXPECT_EQ(errors[c].holes, 1.0);
    EXPECT_EQ(errors[c].leaks, 0.0);
    EXPECT_NEAR(errors[c].total_variation, 1.0, 1e-5) << "no share is where it should be";
  }
}

TEST(BlendTargets, WhatDiffusionBringsRoundAnEdgeIsNoLeak) {
  const auto leaksOfTents = [](int passes) {
    BakeOptions options = metreOptions();
    options.diffusion.passes = passes;
    const Seen seen(sourceOf(sheetFrom(0.3f)), options);
    LightGrid grid;
    grid.tree = seen.scene.treeInWorld();
    grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
    return blendErrors(seen.targets, grid);
  };
  const BlendErrors without = leaksOfTents(0), with = leaksOfTents(2);
  for (size_t c = 1; c < kBlendClassCount; ++c) {
    EXPECT_LT(with[c].leaks, without[c].leaks);
    EXPECT_GT(with[c].leaks, 0.0) << "it does not reach all that is behind";
  }
}

}  // namespace
}  // namespace nlg
