// What stands in the folder weights/. All of these are skipped while no trained weights do.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/theta_policy.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kMaxBytes = 12'000'000;

class ShippedWeights : public testing::Test {
 protected:
  void SetUp() override {
    for (const fs::directory_entry& entry : fs::directory_iterator(NLG_SOURCE_WEIGHTS)) {
      if (entry.path().extension() == ".safetensors") paths_.push_back(entry.path());
    }
    if (paths_.empty()) GTEST_SKIP() << "no trained weights in " << NLG_SOURCE_WEIGHTS;
    std::sort(paths_.begin(), paths_.end());
  }
  std::vector<fs::path> paths_;
};

TEST_F(ShippedWeights, TakeAtMostTwelveMegabytesTogether) {
  uintmax_t bytes = 0;
  for (const fs::path& path : paths_) bytes += fs::file_size(path);
  EXPECT_LE(bytes, kMaxBytes);
}

TEST_F(ShippedWeights, LoadAndAreNamedByTheirRepresentation) {
  for (const fs::path& path : paths_) {
    Generator generator;
    const WeightsResult result = Generator::load(path.string(), &generator);
    ASSERT_TRUE(result.ok()) << result.detail;
    EXPECT_EQ(representationName(generator.representation()), path.stem().string());
  }
}

TEST_F(ShippedWeights, HoldFloat16Matrices) {
  for (const fs::path& path : paths_) {
    WeightsFile file;
    ASSERT_TRUE(readWeightsFile(path.string(), &file).ok()) << path;
    EXPECT_EQ(file.tensors.at("basis.components").dtype, WeightsDtype::float16) << path;
    for (const auto& [name, tensor] : file.tensors) {
      if (!name.ends_with(".weight")) continue;
      EXPECT_EQ(tensor.dtype, WeightsDtype::float16) << path << " " << name;
    }
  }
}

// Walls across the support, as no training saw them: they lie at any angle, with noise in what they hide, farther from levels than
// anything that was trained on. What is trained has at most three quarters of the error of its theta0 all the same.
TEST_F(ShippedWeights, AreTrained) {
  for (const fs::path& path : paths_) {
    Generator generator;
    ASSERT_TRUE(Generator::load(path.string(), &generator).ok()) << path;
    StageRunner runner(generator, PolicyOptions{}, ThetaStage::mirror_images);
    EXPECT_GT(runner.plan().size(), 1u) << path << ": nothing follows the network";
    Theta theta(generator.representation().thetaCount());
    double corrected = 0.0, constant = 0.0;
    for (uint64_t seed = 0; seed < 16; ++seed) {
      const StoredSample wall = wallSample(seed);
      const StoredFunction stored = wall.view();
      ThetaRecord record;
      runner.make(&stored, 1, theta.data(), &record);
      corrected += record.at(ThetaWord::corrected).rmse;
      constant += runner.checker().check(generator.representation(), stored, generator.theta0(), {}).rmse;
    }
    EXPECT_LT(corrected, 0.75 * constant) << path;
  }
}

TEST_F(ShippedWeights, HaveAModelCardEach) {
  std::ifstream stream(fs::path(NLG_SOURCE_WEIGHTS) / "README.md");
  const std::string cards{std::istreambuf_iterator<char>(stream), {}};
  for (const fs::path& path : paths_) {
    EXPECT_NE(cards.find("\n## " + path.stem().string() + "\n"), std::string::npos) << path;
    EXPECT_NE(cards.find(fileSha256(path.string())), std::string::npos) << path << ": another file than its card's";
  }
}

}  // namespace
}  // namespace nlg
