#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nlg/look_up.h"
#include "tests/runtime_eval/counting_new.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/light_grid/look_up_bounds.h"
#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

// A list of positions and normals, and what a batch makes of them.
struct Batch {
  std::vector<PositionM> positions_m;
  std::vector<float> normals;
  std::vector<float> rgb;
  std::vector<LightStatus> status;

  void add(const PositionM& position_m, const float* normal_3) {
    positions_m.push_back(position_m);
    normals.insert(normals.end(), normal_3, normal_3 + 3);
  }
  void run(const LightGrid& grid, LookUpScratch* scratch) {
    rgb.assign(normals.size(), -1.0f);
    status.assign(positions_m.size(), LightStatus::unlit);
    lookUpIrradiances(grid, positions_m.data(), normals.data(), positions_m.size(), rgb.data(), status.data(), scratch);
  }
};

// Scattered positions, and walks of small steps through many cells.
Batch randomBatch(const ProbeTreeFrame& frame, size_t count, uint64_t seed) {
  Random random(seed);
  Batch batch;
  PositionM at{};
  for (size_t i = 0; i < count; ++i) {
    if (i % 64 < 32 || i % 64 == 32) {
      at = randomPosition(frame, random);
    } else {
      for (double& along : at) along += 0.3 * frame.spacing_m;
    }
    batch.add(at, randomDirection(random).data());
  }
  return batch;
}

// How far weights, and so normalised ones times their sum, may be apart that two ways of rounding give.
double weightBound(const LightGrid& grid, const ProbesAround& around) {
  double sum = 0.0;
  for (const ProbeAround& corner : around.corners) {
    const uint32_t function = grid.probe_function[corner.probe];
    if (function == kNoWeight) continue;
    double bound = 12 * kFloatRounding;  // of the tent and its ratio
    if (function != kFreeSpace) {
      const Representation& representation = grid.representations[grid.function_representation[function]];
      // with a sigmoid to 3 units in the last place
      bound += 2 * errorBound(representation, corner.local, thetaOf(grid, function)) + 6 * kFloatRounding;
    }
    sum += bound / (1.0 - kResidue) + 2 * kFloatRounding;
  }
  // and what is left out when it is small
  return sum + 8 * double{kLeastWeight};
}

void expectNear(const LightGrid& grid, const Batch& batch, int64_t* lit) {
  for (size_t i = 0; i < batch.positions_m.size(); ++i) {
    float rgb[3];
    const float* normal = &batch.normals[3 * i];
    const LightStatus status = lookUpIrradiance(grid, batch.positions_m[i], normal, rgb);
    ProbesAround around;
    if (!grid.tree.lookUp(batch.positions_m[i], &around)) {
      ASSERT_EQ(batch.status[i], LightStatus::outside);
      for (size_t c = 0; c < 3; ++c) ASSERT_EQ(batch.rgb[3 * i + c], rgb[c]);
      continue;
    }
    ProbeWeights weights;
    weightsAround(grid, around, &weights);
    double sum = 0.0, most = 0.0;
    for (int k = 0; k < weights.count; ++k) sum += double{weights.weight[k]};
    // of a share; the certainty is a mean over the residue, of which each weight is thrice
    double bound = weightBound(grid, around) / sum;
    if (!(bound < 1.0)) continue;  // whether any weight is left is a matter of rounding
    const double certainty_bound = 3 * bound / kResidue;
    ASSERT_TRUE(batch.status[i] == status || weights.certainty > 1.0 - certainty_bound);
    bound = 2 * bound + (status == LightStatus::faint || batch.status[i] == LightStatus::faint ? certainty_bound : 0.0);
    const std::array<float, kShCount> basis = shBasis(normal[0], normal[1], normal[2]);
    for (const ProbeAround& corner : around.corners) {
      double of_probe = 0.0;
      for (int j = 0; j < kShFloats; ++j)
        of_probe += std::abs(double{kCosineBand[j / 3]} * basis[j / 3] * grid.probeLight(corner.probe)[j]);
      most = std::max(most, of_probe);
    }
    for (size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(batch.rgb[3 * i + c], rgb[c], (bound + 60 * kFloatRounding) * most) << "position " << i;
    *lit += status == LightStatus::lit;
  }
}

TEST(IrradianceBatch, EqualsSingleLookUpsOnEveryTarget) {
  LookUpScratch scratch;
  int64_t lit = 0;
  forEachTarget([&] {
    for (uint64_t seed = 0; seed < 4; ++seed) {
      LightGrid grid = litGrid(randomTree(seed).tree, seed);
      Random random(seed);
      for (uint32_t& function : grid.probe_function) function = seed == 3 && random.chance(0.7) ? kNoWeight : function;
      Batch batch = randomBatch(grid.tree.frame(), 4000, seed);
      batch.run(grid, &scratch);
      expectNear(grid, batch, &lit);
      if (testing::Test::HasFatalFailure()) return;
    }
  });
  EXPECT_GT(lit, 4000);
}

TEST(IrradianceBatch, TakesListsOfAnyLength) {
  const LightGrid grid = litGrid(smallTree(), 1);
  LookUpScratch scratch;
  int64_t lit = 0;
  for (const size_t count : {0, 1, 2, 3, 15, 16, 17, 31, 33, 127, 128, 129, 16383, 16384, 16385, 40000}) {
    Batch batch = randomBatch(grid.tree.frame(), count, count);
    batch.run(grid, &scratch);
    expectNear(grid, batch, &lit);
    if (HasFatalFailure()) FAIL() << count << " positions";
  }
  EXPECT_GT(lit, 4000);
}

TEST(IrradianceBatch, WritesNothingBehindItsLists) {
  const LightGrid grid = litGrid(smallTree(), 1);
  LookUpScratch scratch;
  forEachTarget([&] {
    for (const size_t count : {1, 5, 16, 37}) {
      const Batch batch = randomBatch(grid.tree.frame(), count, count);
      std::vector<float> rgb(3 * count + 64, -7.0f), light(kShFloats * count + 64, -7.0f);
      std::vector<LightStatus> status(count + 64, LightStatus::faint);
      lookUpIrradiances(grid, batch.positions_m.data(), batch.normals.data(), count, rgb.data(), status.data(), &scratch);
      lookUpLights(grid, batch.positions_m.data(), count, light.data(), status.data(), &scratch);
      EXPECT_TRUE(std::all_of(rgb.end() - 64, rgb.end(), [](float value) { return value == -7.0f; })) << count;
      EXPECT_TRUE(std::all_of(light.end() - 64, light.end(), [](float value) { return value == -7.0f; })) << count;
      EXPECT_TRUE(std::all_of(status.end() - 64, status.end(), [](LightStatus s) { return s == LightStatus::faint; }));
    }
  });
}

TEST(IrradianceBatch, GivesAPositionTheSameBitsInAnyCompany) {
  const LightGrid grid = litGrid(smallTree(), 2);
  LookUpScratch scratch;
  forEachTarget([&] {
    Batch all = randomBatch(grid.tree.frame(), 3000, 2), reversed, some;
    for (size_t i = all.positions_m.size(); i-- > 0;) reversed.add(all.positions_m[i], &all.normals[3 * i]);
    for (size_t i = 0; i < all.positions_m.size(); i += 7) some.add(all.positions_m[i], &all.normals[3 * i]);
    for (Batch* batch : {&all, &reversed, &some}) batch->run(grid, &scratch);
    for (size_t i = 0; i < all.positions_m.size(); ++i) {
      const size_t back = all.positions_m.size() - 1 - i;
      ASSERT_EQ(all.status[i], reversed.status[back]) << i;
      ASSERT_TRUE(std::equal(&all.rgb[3 * i], &all.rgb[3 * i] + 3, &reversed.rgb[3 * back])) << i;
      if (i % 7 != 0) continue;
      ASSERT_EQ(all.status[i], some.status[i / 7]) << i;
      ASSERT_TRUE(std::equal(&all.rgb[3 * i], &all.rgb[3 * i] + 3, &some.rgb[3 * (i / 7)])) << i;
    }
  });
}

TEST(IrradianceBatch, DoesAsSingleLookUpsWherePositionsOrNormalsAreNone) {
  const LightGrid grid = litGrid(smallTree(), 3);
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const PositionM inside = positionAt(grid.tree.frame(), {1.0, 20.25, 20.5});
  Batch batch;
  const float up[3] = {0, 0, 1}, none[3] = {0, std::nanf(""), 1}, far[3] = {0, 3e38f, 0};
  for (const float* normal : {up, none, far}) {
    for (const double x : {inside[0], nan, infinity, -infinity, 1e300, inside[0] - 0.8, inside[0] - 40.0})
      batch.add({x, inside[1], inside[2]}, normal);
  }
  LookUpScratch scratch;
  batch.run(grid, &scratch);
  EXPECT_EQ(batch.status[0], LightStatus::lit);
  for (size_t i = 1; i < batch.positions_m.size(); ++i) {
    float rgb[3];
    EXPECT_EQ(batch.status[i], lookUpIrradiance(grid, batch.positions_m[i], &batch.normals[3 * i], rgb)) << i;
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(batch.rgb[3 * i + c], rgb[c]) << i;
  }
}

TEST(IrradianceBatch, AllocatesNothing) {
  const LightGrid grid = litGrid(smallTree(), 3);
  Batch batch = randomBatch(grid.tree.frame(), 10000, 3);
  LookUpScratch scratch;
  batch.run(grid, &scratch);
  const long before = allocationCount();
  lookUpIrradiances(grid, batch.positions_m.data(), batch.normals.data(), batch.positions_m.size(), batch.rgb.data(),
                    batch.status.data(), &scratch);
  EXPECT_EQ(allocationCount(), before);
}

}  // namespace
}  // namespace nlg
