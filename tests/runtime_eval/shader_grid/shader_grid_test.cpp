#include "nlg/shader_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "nlg/look_up.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/sample_functions.h"
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
  for (const char* define : {"NLG_NETWORK_4", "NLG_NETWORK_44", "NLG_NETWORK_88", "NLG_FIELD", "NLG_BRICK"})
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

// Light of three groups, mixed by the head's colours.
TEST_P(ShaderGridPrecision, SaysWhatAMixOfGroupsSays) {
  LightGrid grid = everyRepresentation(GetParam(), 13);
  for (uint64_t g = 0; g < 3; ++g)
    grid.groups.push_back({"group " + std::to_string(g), randomLight(grid.tree.probeCount(), 20 + g), g == 2});
  roundGridLight(kLightError, &grid);
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.groups, (std::vector<std::string>{"group 0", "group 1", "group 2"}));
  for (size_t g = 0; g < 3; ++g)
    EXPECT_EQ(packed.words[4 * (static_cast<size_t>(packed.first_colour) + g)], std::bit_cast<uint32_t>(g < 2 ? 1.0f : 0.0f))
        << g;
  const std::vector<std::array<float, 3>> colours = {{1.0f, 0.5f, 0.25f}, {0.0f, 0.0f, 0.0f}, {0.5f, 2.0f, 1.0f}};
  ASSERT_TRUE(mixLight(colours, &grid).ok());
  for (size_t g = 0; g < 3; ++g) {
    for (size_t c = 0; c < 3; ++c)
      packed.words[4 * (static_cast<size_t>(packed.first_colour) + g) + c] = std::bit_cast<uint32_t>(colours[g][c]);
  }
  glsl::shader_grid = &packed;
  Random random(15);
  for (int i = 0; i < 2000; ++i) {
    const PositionM at = randomPlace(grid.tree.frame(), random);
    const std::array<float, 3> normal = randomNormal(random);
    float rgb[3], light[kShFloats];
    const LightStatus status = lookUpIrradiance(grid, at, normal.data(), rgb);
    lookUpLight(grid, at, light);
    const glsl::NlgLight shaded = shade(at, normal);
    const glsl::NlgRadiance radiance = glsl::nlgRadiance(vectorOf(at));
    ASSERT_EQ(shaded.status, static_cast<int>(status)) << at[0] << ' ' << at[1] << ' ' << at[2];
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(shaded.irradiance[c], rgb[c], 1e-3f * std::max(1.0f, rgb[c])) << i;
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

TEST(ShaderGrid, ShowsBricksOfEveryStep) {
  const Representation code = Representation::code(sampleDictionary(7, 16, 1));
  LightGrid grid = freeGrid();
  grid.representations = {code};
  Random random(8);
  for (uint32_t& function : grid.probe_function) {
    Theta theta = sampleCode(*code.dictionary, 16, random);
    const auto scale = static_cast<float>(std::pow(10.0, random.uniform(-1.0, 4.0)));
    for (float& z : theta) z *= scale;
    function = grid.addFunction(0, theta.data());
  }
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  glsl::shader_grid = &packed;
  float least = HUGE_VALF, most = 0.0f;
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    const uint32_t function = grid.probe_function[probe];
    const float step = grid.function_brick[function].step;
    least = std::min(least, step), most = std::max(most, step);
    glsl::NlgCorner corner{};
    corner.record = static_cast<int>(packed.probe_record[probe]);
    corner.kind = static_cast<int>(glsl::nlgHeader(glsl::NLG_CLASSES).w);
    corner.resolution = static_cast<int>(glsl::nlgHeader(glsl::NLG_CLASSES + 1).w);
    for (int i = 0; i < 20; ++i) {
      const LocalPoint at = {static_cast<float>(random.uniform(-1.0, 1.0)), static_cast<float>(random.uniform(-1.0, 1.0)),
                             static_cast<float>(random.uniform(-1.0, 1.0))};
      corner.local = {at[0], at[1], at[2]};
      // positions up to 6 with 3 roundings along each axis, where a cell holds 254 steps at most; 7 interpolations of 3 roundings each;
      // on both sides, under a slope of 1/4, and the sigmoid
      const float bound = static_cast<float>(kFloatRounding) * (2 * (3 * 3 * 6 * 254 + 7 * 3 * 127) * step / 4 + 8);
      ASSERT_NEAR(glsl::nlgTentShare(corner), evaluateQuads(7, at, step, grid.functionQuads(function)), bound) << step;
    }
  }
  EXPECT_EQ(least, std::ldexp(1.0f, kLeastStepExponent));
  EXPECT_GT(most, 1e2f);
}

// In the coordinates of a map of the earth a float's step is half a metre.
TEST(ShaderGrid, RefusesACornerThatNoFloatHoldsUntilItIsMoved) {
  const LightGrid near = everyRepresentation(ThetaPrecision::int8, 3);
  LightGrid far = near;
  far.tree.moveBy({500000.0, 0.0, 4649776.0});
  const double error_m = cornerErrorM(far.tree.frame());
  double expected = 0.0;
  for (const double at : far.tree.frame().first_m)
    expected = std::max(expected, std::abs(at - static_cast<double>(static_cast<float>(at))));
  EXPECT_EQ(error_m, expected);
  EXPECT_LE(error_m, 0.25);
  far.tree.moveBy({0.0, 0.0, 0.13});
  ShaderGrid packed, packed_near;
  const FileResult refused = packShaderGrid(far, &packed);
  EXPECT_EQ(refused.status, FileStatus::value_out_of_range);
  EXPECT_NE(refused.detail.find("--origin-m"), std::string::npos) << refused.detail;
  far.tree.moveBy({-500000.0, 0.0, -4649776.13});
  EXPECT_LT(cornerErrorM(far.tree.frame()), 1e-6);
  ASSERT_TRUE(packShaderGrid(far, &packed).ok());
  ASSERT_TRUE(packShaderGrid(near, &packed_near).ok());
  EXPECT_TRUE(std::equal(packed.words.begin() + 16, packed.words.end(), packed_near.words.begin() + 16))
      << "all but the corner and the digest";
}

}  // namespace
}  // namespace nlg
