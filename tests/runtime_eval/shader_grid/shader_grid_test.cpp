#include "nlg/shader_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

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
  for (int i = 0; i < 5000; ++i) {
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

// Light of few dimensions, as levels have it: records of 16 bytes at most.
std::vector<float> levelLight(size_t probe_count, uint64_t seed) {
  Random random(seed);
  const std::vector<float> lamps = randomLight(3, seed);
  std::vector<float> light(probe_count * kShFloats, 0.0f);
  for (size_t probe = 0; probe < probe_count; ++probe) {
    for (size_t lamp = 0; lamp < 3; ++lamp) {
      const auto share = static_cast<float>(random.uniform());
      for (size_t i = 0; i < kShFloats; ++i) light[probe * kShFloats + i] += share * lamps[lamp * kShFloats + i];
    }
  }
  return light;
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
    grid.light = levelLight(grid.tree.probeCount(), 1);
    ShaderGrid packed;
    ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
    const size_t light_bytes = packed.light_bytes / grid.tree.probeCount();
    EXPECT_LE(light_bytes, 16u);
    EXPECT_EQ(packed.theta_bytes / grid.functionCount() + light_bytes, 16 + (kind == RepresentationKind::tent_mlp4 ? 32u : 128u));
    glsl::shader_grid = &packed;
    const int most = 4 + 4 + 8 * 4 + 8 * static_cast<int>(packed.largest_read);
    EXPECT_EQ(most, kind == RepresentationKind::tent_mlp4 ? 424 : 1192);
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

TEST(ShaderGrid, ReadsTwoWordsOfABrick) {
  const Representation code = Representation::code(sampleDictionary(9, 64, 1));
  LightGrid grid = freeGrid();
  grid.light = levelLight(grid.tree.probeCount(), 2);
  grid.representations = {code};
  Random random(7);
  for (uint32_t& function : grid.probe_function) function = grid.addFunction(0, sampleCode(*code.dictionary, 64, random).data());
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.largest_read, 16 + 4 + 8u);
  glsl::shader_grid = &packed;
  const int most = 4 + 4 + 8 * 4 + 8 * static_cast<int>(packed.largest_read);
  EXPECT_EQ(most, 264);
  int largest = 0;
  for (int i = 0; i < 2000; ++i) {
    const PositionM at = randomPosition(grid.tree.frame(), random);
    ProbesAround around;
    if (!grid.tree.lookUp(at, &around)) continue;
    glsl::reads = 0;
    const glsl::NlgLight light = shade(asFloats(at), randomNormal(random));
    // of faint light each record's first four once more
    ASSERT_LE(glsl::reads, light.status == static_cast<int>(LightStatus::faint) ? most + 8 * 16 : most);
    if (light.status == static_cast<int>(LightStatus::lit)) largest = std::max(largest, glsl::reads);
  }
  EXPECT_EQ(largest, most);
}

TEST(ShaderGrid, HoldsABrickOnceForAllProbesThatShareIt) {
  const Representation code = Representation::code(sampleDictionary(5, 16, 1));
  LightGrid grid = freeGrid();
  grid.representations = {code};
  Random random(7);
  // a function that no probe has comes first
  for (int i = 0; i < 4; ++i) grid.addFunction(0, sampleCode(*code.dictionary, 16, random).data());
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.theta_bytes, 0u);
  const size_t light_words = packed.light_bytes / sizeof(uint32_t) / grid.tree.probeCount();
  const size_t record_bytes = (light_words + 1 + 3) / 4 * 16;
  for (size_t probe = 0; probe < 30; ++probe) grid.probe_function[probe] = 3 - static_cast<uint32_t>(probe) % 3;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.defines[0], "NLG_BRICK");
  EXPECT_EQ(packed.defines[1], "NLG_CLASS_COUNT 3");
  const size_t quads = quadCount(5);
  EXPECT_EQ(packed.theta_bytes, 30 * (record_bytes - 4 * light_words) + 3 * quads * sizeof(uint32_t));
  // one behind another in the order of probes, behind all records
  const size_t first = packed.words.size() - 3 * quads;
  for (uint32_t probe = 0; probe < 30; ++probe) {
    const uint32_t name = packed.words[4 * packed.probe_record[probe] + light_words], function = grid.probe_function[probe];
    ASSERT_EQ(4 * (name & 0x7ffffff), first + quads * (probe % 3));
    ASSERT_EQ(std::ldexp(1.0f, static_cast<int>(name >> 27) - 4), grid.function_brick[function].step);
    ASSERT_TRUE(
        std::equal(grid.functionQuads(function), grid.functionQuads(function) + quads, &packed.words[4 * (name & 0x7ffffff)]));
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

TEST(ShaderGrid, NamesWhatItIsToBeCompiledFor) {
  LightGrid grid = freeGrid();
  ShaderGrid packed;
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  const std::string axes = "NLG_LIGHT_AXES " + std::to_string(packed.words[16]);
  const std::string words = "NLG_LIGHT_WORDS " + std::to_string(packed.words[18]);
  // where each axis's number stands, as the head has it
  std::string fields = "NLG_LIGHT_FIELDS uint[](";
  for (uint32_t k = 0; k < packed.words[16]; ++k)
    fields += (k > 0 ? ", " : "") + std::to_string(packed.words[4 * (5 + 2 * 2) + 28 * k + 27]) + 'u';
  EXPECT_EQ(packed.defines, (std::vector<std::string>{"NLG_CLASS_COUNT 2", axes, words, fields + ")"}));
  EXPECT_EQ(packed.theta_bytes, 0u);
  EXPECT_EQ(packed.light_bytes, 4 * packed.words[18] * grid.tree.probeCount());
  grid.representations = {{RepresentationKind::tent_mlp4}};
  grid.probe_function[0] = grid.addFunction(0, randomTheta(grid.representations[0], 1).data());
  ASSERT_TRUE(packShaderGrid(grid, &packed).ok());
  EXPECT_EQ(packed.defines,
            (std::vector<std::string>{"NLG_NETWORK_4", "NLG_HALVES", "NLG_CLASS_COUNT 3", axes, words, fields + ")"}));
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
  const Representation code = Representation::code(sampleDictionary(3, 8, 1));
  grid.representations.push_back(code);
  grid.probe_function[0] = grid.addFunction(1, Theta(8, kMaxGridTheta).data());
  grid.probe_function[1] = grid.addFunction(1, Theta(8, 100.0f).data());
  EXPECT_TRUE(packShaderGrid(grid, &packed).ok());
  DictionaryData steep = code.dictionary->data();
  for (int8_t& exponent : steep.exponents) exponent += 24;
  grid.representations[1] = Representation::code(std::make_shared<const Dictionary>(std::move(steep)));
  grid.makeBricks();
  const FileResult logits = packShaderGrid(grid, &packed);
  EXPECT_NE(logits.detail.find("logits beyond"), std::string::npos) << logits.detail;
  EXPECT_TRUE(packed.words.empty());
}

}  // namespace
}  // namespace nlg
