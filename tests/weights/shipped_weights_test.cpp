// What stands in the folder weights/. All of these are skipped while no trained weights do.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "runtime_eval/policy/stage_runner.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/atomic_file.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kMaxBytes = 32'000'000;

class ShippedWeights : public testing::Test {
 protected:
  void SetUp() override {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(NLG_SOURCE_WEIGHTS)) {
      if (entry.path().extension() == ".safetensors") paths_.push_back(entry.path());
    }
    if (paths_.empty()) GTEST_SKIP() << "no trained weights in " << NLG_SOURCE_WEIGHTS;
    std::sort(paths_.begin(), paths_.end());
  }
  std::vector<fs::path> paths_;
};

TEST_F(ShippedWeights, TakeAtMost32MegabytesTogether) {
  uintmax_t bytes = 0;
  for (const fs::path& path : paths_) bytes += fs::file_size(path);
  EXPECT_LE(bytes, kMaxBytes);
}

TEST_F(ShippedWeights, LoadAndAreNamedByTheirRepresentation) {
  for (const fs::path& path : paths_) {
    Generator generator;
    const FileResult result = Generator::load(path.string(), &generator);
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

// Walls at any angle, with noise in what they hide: farther from levels than anything that was trained on.
struct Walls {
  static constexpr int kCount = 64;
  std::vector<StoredSample> samples;
  Walls() {
    for (uint64_t seed = 0; seed < kCount; ++seed) samples.push_back(wallSample(seed));
  }
};

// What the network alone predicts fits its own wall better than theta0 does, and better than what it predicts for another wall: of
// all 64 ways to shift the predictions along the walls, none comes as near as no shift. A network that knows nothing of its input
// passes neither, and one of mixed-up inputs passes in one of 64.
TEST_F(ShippedWeights, PredictTheirOwnFunction) {
  const Walls walls;
  for (const fs::path& path : paths_) {
    Generator generator;
    ASSERT_TRUE(Generator::load(path.string(), &generator).ok()) << path;
    const Representation& representation = generator.representation();
    GeneratorScratch scratch(generator);
    std::vector<Theta> predicted;
    std::vector<WeightingFunction> functions;
    double constant = 0.0;
    for (const StoredSample& wall : walls.samples) {
      const StoredFunction function = wall.view();
      generator.generate(&function, 1, predicted.emplace_back(representation.thetaCount()).data(), &scratch);
      functions.push_back(decoded(wall.view(), pointOrder(representation)));
      constant += functionRmse(representation, functions.back(), generator.theta0());
    }
    const auto shifted = [&](int shift) {
      double sum = 0.0;
      for (int i = 0; i < Walls::kCount; ++i)
        sum += functionRmse(representation, functions[i], predicted[(i + shift) % Walls::kCount].data());
      return sum;
    };
    const double own = shifted(0);
    EXPECT_LT(own, constant) << path;
    for (int shift = 1; shift < Walls::kCount; ++shift) EXPECT_LT(own, shifted(shift)) << path << ", shifted by " << shift;
  }
}

// The promise of what follows the network and reads the samples, short fits included: at most half of theta0's error.
TEST_F(ShippedWeights, HaveStagesThatHalveTheErrorOfTheta0) {
  const Walls walls;
  for (const fs::path& path : paths_) {
    Generator generator;
    ASSERT_TRUE(Generator::load(path.string(), &generator).ok()) << path;
    StageRunner runner(generator, PolicyOptions{});
    FunctionChecker checker;
    Theta theta(generator.representation().thetaCount());
    double fitted = 0.0, constant = 0.0;
    for (const StoredSample& wall : walls.samples) {
      const StoredFunction stored = wall.view();
      ThetaRecord record;
      runner.make(&stored, 1, theta.data(), &record);
      fitted += record.at(ThetaWord::fitted).rmse;
      constant += checker.check(generator.representation(), stored, generator.theta0(), {}).rmse;
    }
    EXPECT_LE(fitted, 0.5 * constant) << path;
  }
}

TEST_F(ShippedWeights, AreThoseOfTheirCards) {
  for (const fs::path& path : paths_) {
    std::ifstream stream(path.parent_path() / "README.md");
    const std::string cards{std::istreambuf_iterator<char>(stream), {}};
    const std::string line = "| `" + path.filename().string() + "` | `" + fileSha256(path.string()) + "` |\n";
    EXPECT_NE(cards.find(line), std::string::npos) << "no card says " << line;
  }
}

}  // namespace
}  // namespace nlg
