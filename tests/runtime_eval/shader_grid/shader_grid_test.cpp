#include "runtime_eval/shader_grid/shader_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/irradiance.h"
#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"
#include "tests/runtime_eval/shader_grid/glsl_as_cpp.h"

namespace nlg {
namespace {

glsl::vec3 vectorOf(const PositionM& position_m) {
  return {static_cast<float>(position_m[0]), static_cast<float>(position_m[1]), static_cast<float>(position_m[2])};
}

glsl::NlgLight shade(const PositionM& position_m, const std::array<float, 3>& normal) {
  return glsl::nlgIrradiance(vectorOf(position_m), {normal[0], normal[1], normal[2]});
}

class ShaderGridPrecision : public testing::TestWithParam<ThetaPrecision> {};

TEST_P(ShaderGridPrecision, SaysWhatTheLookUpSays) {
  const LightGrid grid = everyRepresentation(GetParam(), 3);
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  for (const char* define : {"NLG_NETWORK_4", "NLG_NETWORK_44", "NLG_NETWORK_88", "NLG_FIELD"})
    EXPECT_EQ(std::count(packed.defines.begin(), packed.defines.end(), define), 1) << define;
  glsl::shader_grid = &packed;
  Random random(5);
  std::array<int, 4> count{};
  for (int i = 0; i < 20000; ++i) {
    const PositionM at = randomPlace(grid.tree.frame(), random);
    const std::array<float, 3> normal = randomNormal(random);
    float rgb[3];
    const LightStatus status = lookUpIrradiance(grid, at, normal.data(), rgb);
    const glsl::NlgLight shaded = shade(at, normal);
    ASSERT_EQ(shaded.status, static_cast<int>(status)) << at[0] << ' ' << at[1] << ' ' << at[2];
    ++count[static_cast<size_t>(status)];
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(shaded.irradiance[c], rgb[c], 1e-3f * std::max(1.0f, rgb[c])) << i;
  }
  for (const LightStatus status : {LightStatus::lit, LightStatus::faint, LightStatus::unlit, LightStatus::outside})
    EXPECT_GT(count[static_cast<size_t>(status)], 20) << lightStatusName(status);
}

TEST_P(ShaderGridPrecision, SaysTheRadianceOfTheLookUp) {
  const LightGrid grid = everyRepresentation(GetParam(), 9);
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  glsl::shader_grid = &packed;
  Random random(10);
  for (int i = 0; i < 5000; ++i) {
    const PositionM at = randomPlace(grid.tree.frame(), random);
    float light[kShFloats];
    const LightStatus status = lookUpLight(grid, at, light);
    const glsl::NlgRadiance radiance = glsl::nlgRadiance(vectorOf(at));
    ASSERT_EQ(radiance.status, static_cast<int>(status));
    for (int k = 0; k < kShFloats; ++k)
      ASSERT_NEAR(radiance.sh[k / kShChannels][k % kShChannels], light[k], 1e-3f * std::max(1.0f, std::abs(light[0]))) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, ShaderGridPrecision, testing::Values(ThetaPrecision::int8, ThetaPrecision::float16),
                         [](const auto& precision) { return std::string(thetaPrecisionName(precision.param)); });

TEST(ShaderGrid, IsDarkWhereAPositionIsNoNumber) {
  const LightGrid grid = everyRepresentation(ThetaPrecision::int8, 4);
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  glsl::shader_grid = &packed;
  const PositionM inside = grid.tree.probePosition(0);
  for (const double broken : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e30, -1e30}) {
    for (size_t axis = 0; axis < 3; ++axis) {
      PositionM at = inside;
      at[axis] = broken;
      const glsl::NlgLight shaded = shade(at, {0.0f, 0.0f, 1.0f});
      EXPECT_EQ(shaded.status, static_cast<int>(LightStatus::outside));
      for (int c = 0; c < 3; ++c) EXPECT_EQ(shaded.irradiance[c], 0.0f);
    }
  }
}

// What a pixel reads at most: a block, eight slots, and eight records.
TEST(ShaderGrid, ReadsNoMoreThanEightRecords) {
  for (const RepresentationKind kind : {RepresentationKind::tent_mlp4, RepresentationKind::tent_mlp}) {
    LightGrid grid;
    grid.tree = smallTree();
    grid.representations = {{kind}};
    Theta theta = randomTheta(grid.representations[0], 1);
    ASSERT_TRUE(roundTheta(grid.representations[0], ThetaPrecision::int8, theta.data()));
    for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe)
      grid.probe_function.push_back(probe % 2 == 0 ? grid.addFunction(0, theta.data()) : kFreeSpace);
    grid.light = randomLight(grid.tree.probeCount(), 1);
    ShaderGrid packed;
    ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
    EXPECT_EQ(packed.theta_bytes / grid.functionCount(), kind == RepresentationKind::tent_mlp4 ? 32u : 128u);
    glsl::shader_grid = &packed;
    const int most = 4 + 4 + 8 * 4 + 8 * static_cast<int>(packed.largest_read);
    EXPECT_EQ(most, kind == RepresentationKind::tent_mlp4 ? 552 : 1320);
    Random random(6);
    for (int i = 0; i < 2000; ++i) {
      const PositionM at = randomPosition(grid.tree.frame(), random);
      ProbesAround around;
      if (!grid.tree.lookUp(at, &around)) continue;
      glsl::reads = 0;
      const glsl::NlgLight light = shade(asFloats(at), randomNormal(random));
      // of faint light each record's first four once more
      EXPECT_LE(glsl::reads, light.status == static_cast<int>(LightStatus::faint) ? most + 8 * 16 : most);
    }
  }
}

TEST(ShaderGrid, NamesWhatItIsToBeCompiledFor) {
  LightGrid grid = freeGrid();
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.defines, std::vector<std::string>{"NLG_CLASS_COUNT 2"});
  EXPECT_EQ(packed.theta_bytes, 0u);
  EXPECT_EQ(packed.light_bytes, 32 * grid.tree.probeCount());
  grid.representations = {{RepresentationKind::tent_mlp4}};
  grid.probe_function[0] = grid.addFunction(0, randomTheta(grid.representations[0], 1).data());
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.defines, (std::vector<std::string>{"NLG_NETWORK_4", "NLG_HALVES", "NLG_CLASS_COUNT 3"}));
}

TEST(ShaderGrid, RefusesWhatShadersCannotShow) {
  LightGrid grid = freeGrid();
  grid.light.clear();
  ShaderGrid packed;
  const FileResult dark = packShaderGrid(grid, &packed);
  EXPECT_EQ(dark.status, FileStatus::value_out_of_range);
  EXPECT_NE(dark.detail.find("without light"), std::string::npos) << dark.detail;
  EXPECT_TRUE(packed.words.empty());
  grid.light = randomLight(grid.tree.probeCount(), 1);
  grid.representations = {Representation::tentMlp()};
  Theta theta = randomTheta(grid.representations[0], 1);
  theta[0] = 1e6f;
  grid.probe_function[0] = grid.addFunction(0, theta.data());
  const FileResult beyond = packShaderGrid(grid, &packed);
  EXPECT_NE(beyond.detail.find("float16"), std::string::npos) << beyond.detail;
  EXPECT_TRUE(packed.words.empty());
}

}  // namespace
}  // namespace nlg
