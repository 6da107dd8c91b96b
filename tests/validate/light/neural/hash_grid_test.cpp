#include "validate/light/neural/neural_volume.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// 9 x 5 x 3 m of a cube of 9 m, so that no axis is like another.
HashGrid smallGrid(int table_log2) { return {4.5, {-1.0f, -0.55f, -0.3f}, {1.0f, 0.56f, 0.37f}, table_log2}; }

torch::Tensor randomPlaces(int64_t count, uint64_t seed) {
  torch::Tensor places = torch::empty({count, 3});
  Random random(seed);
  for (int64_t i = 0; i < places.numel(); ++i) places.data_ptr<float>()[i] = static_cast<float>(random.uniform(-1.0, 1.0));
  return places;
}

torch::Tensor randomTable(const HashGrid& grid, uint64_t seed) {
  torch::Tensor table = torch::empty({static_cast<int64_t>(grid.rowCount()) * kHashFeatures});
  Random random(seed);
  for (int64_t i = 0; i < table.numel(); ++i) table.data_ptr<float>()[i] = static_cast<float>(random.normal());
  return table;
}

TEST(HashGrid, ReproducesWhatIsLinearInPlaceByItsCoarsestLevel) {
  const HashGrid grid = smallGrid(16);
  // the features of the coarsest level's nodes are a linear function of where they stand
  std::vector<float> table(grid.rowCount() * kHashFeatures, 0.0f);
  const glm::vec3 low(-1.0f, -0.55f, -0.3f);
  const float cell = 2.0f / kCoarsestCells;
  const auto linear = [](const glm::vec3& p) { return 0.3f + p.x - 2.0f * p.y + 0.5f * p.z; };
  for (uint32_t z = 0, row = 0; z < 7; ++z) {
    for (uint32_t y = 0; y < 10; ++y) {
      for (uint32_t x = 0; x < 18; ++x, ++row) table[row * kHashFeatures] = linear(low + cell * glm::vec3(x, y, z));
    }
  }
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const glm::vec3 place(random.uniform(-1.0, 1.0), random.uniform(-0.55, 0.56), random.uniform(-0.3, 0.37));
    float features[kHashOutputs];
    grid.featuresAt(&place.x, table.data(), features);
    // values up to 4 in float
    EXPECT_NEAR(features[0], linear(place), 1e-5f);
    for (int f = 1; f < kHashOutputs; ++f) EXPECT_EQ(features[f], 0.0f);
  }
}

// The features are linear in the table: a difference over any step is exact but for rounding.
TEST(HashGrid, GradientIsThatOfFiniteDifferences) {
  const HashGrid grid = smallGrid(6);  // so small that rows are shared within a level
  const torch::Tensor places = randomPlaces(40, 5);
  const torch::Tensor table = randomTable(grid, 6).requires_grad_();
  const torch::Tensor by_feature =
      randomPlaces(40 * kHashOutputs / 3 + 1, 7).flatten().narrow(0, 0, 40 * kHashOutputs).view({40, kHashOutputs});
  (hashFeatures(grid, places, table) * by_feature).sum().backward();
  const torch::NoGradGuard no_gradients;
  const auto valueWith = [&](int64_t number, float step) {
    torch::Tensor moved = table.detach().clone();
    moved.data_ptr<float>()[number] += step;
    return (hashFeatures(grid, places, moved) * by_feature).to(torch::kDouble).sum().item<double>();
  };
  int not_zero = 0;
  for (int64_t number = 0; number < table.numel(); number += 7) {
    const double slope = table.grad().data_ptr<float>()[number];
    // sums of 640 floats of size 1
    EXPECT_NEAR(slope, (valueWith(number, 1.0f) - valueWith(number, -1.0f)) / 2.0, 1e-4) << "number " << number;
    not_zero += slope != 0.0;
  }
  EXPECT_GT(not_zero, 20);
}

}  // namespace
}  // namespace nlg
