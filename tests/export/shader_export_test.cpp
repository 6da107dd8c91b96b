#include "export/shader/shader_export.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "runtime_eval/evaluator/theta_form.h"
#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

ShaderGrid packedGrid() {
  LightGrid grid = freeGrid();
  grid.representations = {{RepresentationKind::tent_mlp4}};
  Theta theta = randomTheta(grid.representations[0], 1);
  EXPECT_TRUE(roundTheta(grid.representations[0], ThetaPrecision::int8, theta.data()));
  grid.probe_function[0] = grid.addFunction(0, theta.data());
  ShaderGrid packed;
  EXPECT_TRUE(packShaderGrid(grid, &packed).ok());
  return packed;
}

TEST(ShaderExport, DefinesWhatTheGridHoldsBeforeTheLookUp) {
  const std::string text = shaderText(packedGrid());
  const size_t network = text.find("#define NLG_NETWORK_4\n"), classes = text.find("#define NLG_CLASS_COUNT 3\n"),
               look_up = text.find("NlgLight nlgIrradiance(");
  EXPECT_LT(network, look_up);
  EXPECT_LT(classes, look_up);
  EXPECT_NE(look_up, std::string::npos);
  EXPECT_EQ(text.find("#define NLG_FIELD"), std::string::npos);
}

TEST(ShaderExport, WritesTheGridAndItsShaders) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "shader_export" / "made";
  std::filesystem::remove_all(folder);
  const ShaderGrid packed = packedGrid();
  writeShader(packed, folder.string());
  EXPECT_EQ(std::filesystem::file_size(folder / "grid.bin"), 4 * packed.words.size());
  EXPECT_EQ(std::filesystem::file_size(folder / "look_up.glsl"), shaderText(packed).size());
  EXPECT_EQ(std::filesystem::file_size(folder / "resample.comp"), kResampleText.size());
  EXPECT_EQ(std::filesystem::file_size(folder / "resampled.glsl"), kResampledText.size());
  // #version stands before everything else
  EXPECT_EQ(kResampleText.find("#version 450\n"), 0u);
}

}  // namespace
}  // namespace nlg
