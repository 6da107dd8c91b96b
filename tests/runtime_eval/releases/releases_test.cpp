// Files of every release since 1.0 are read, and mean what they meant. make_release_files wrote them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "nlg/light_grid.h"
#include "nlg/look_up.h"
#include "tests/runtime_eval/releases/release_files.h"

namespace nlg {
namespace {

// Targets sum in other orders.
constexpr float kTolerance = 1e-3f;

std::vector<std::filesystem::path> releases() {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(NLG_RELEASES))
    if (entry.is_directory()) folders.push_back(entry.path());
  return folders;
}

TEST(Releases, GridsGiveTheLightThatTheyGave) {
  ASSERT_FALSE(releases().empty());
  for (const std::filesystem::path& folder : releases()) {
    SCOPED_TRACE(folder.string());
    LightGrid grid;
    GridMetadata metadata;
    const FileResult read = readLightGridFile((folder / "grid.safetensors").string(), &grid, &metadata);
    ASSERT_TRUE(read.ok()) << read.detail;
    ASSERT_EQ(grid.groups.size(), 2u);
    EXPECT_TRUE(grid.groups[1].begins_dark);
    ASSERT_TRUE(mixLight(kBothLit, &grid).ok());
    std::ifstream answers(folder / "look_ups.txt");
    PositionM at;
    float normal[3], expected[3], rgb[3];
    int count = 0;
    for (; answers >> at[0] >> at[1] >> at[2] >> normal[0] >> normal[1] >> normal[2] >> expected[0] >> expected[1] >> expected[2];
         ++count) {
      ASSERT_EQ(lookUpIrradiance(grid, at, normal, rgb), LightStatus::lit) << count;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], expected[c], kTolerance * (1e-3f + std::fabs(expected[c]))) << count;
    }
    EXPECT_EQ(count, 200);
  }
}

TEST(Releases, WeightsGiveTheThetaThatTheyGave) {
  ASSERT_FALSE(releases().empty());
  for (const std::filesystem::path& folder : releases()) {
    std::ifstream stream(folder / "functions.bin", std::ios::binary);
    const std::vector<uint8_t> functions((std::istreambuf_iterator<char>(stream)), {});
    ASSERT_GT(functions.size(), 0u);
    for (const std::string name : {"tent_mlp", "code16"}) {
      SCOPED_TRACE((folder / name).string());
      const std::vector<std::vector<float>> thetas = thetasOf((folder / (name + ".safetensors")).string(), functions);
      ASSERT_EQ(thetas.size(), functions.size() / kSupportPointCount);
      std::ifstream answers(folder / (name + ".txt"));
      std::string line;
      for (const std::vector<float>& theta : thetas) {
        ASSERT_TRUE(std::getline(answers, line));
        std::istringstream numbers(line);
        const std::vector<float> expected((std::istream_iterator<float>(numbers)), {});
        ASSERT_EQ(expected.size(), theta.size());
        for (size_t i = 0; i < theta.size(); ++i)
          EXPECT_NEAR(theta[i], expected[i], kTolerance * (1.0f + std::fabs(expected[i])));
      }
    }
  }
}

}  // namespace
}  // namespace nlg
