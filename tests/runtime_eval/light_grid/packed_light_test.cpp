
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/grid_file/light_records.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr size_t kProbes = 2000;

// Radiance of a few lamps from random directions and an even sky, over nine decades of brightness: what probes hold.
std::vector<float> lampLight(uint64_t seed) {
  Random random(seed);
  std::vector<float> light(kProbes * kShFloats, 0.0f);
  for (size_t probe = 0; probe < kProbes; ++probe) {
    const double bright = std::pow(10.0, random.uniform(-3.0, 6.0));
    for (int lamp = 0; lamp < 4; ++lamp) {
      const double z = random.uniform(-1.0, 1.0), turn = random.uniform(0.0, 6.283185307179586), r = std::sqrt(1.0 - z * z);
      const std::array<float, kShCount> basis =
          shBasis(static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)), static_cast<float>(z));
      for (int c = 0; c < kShChannels; ++c) {
        const auto power = static_cast<float>(bright * random.uniform());
        for (int i = 0; i < kShCount; ++i)
          light[probe * kShFloats + static_cast<size_t>(i * kShChannels + c)] += power * basis[i];
        light[probe * kShFloats + static_cast<size_t>(c)] += power;
      }
    }
  }
  return light;
}

std::vector<float> unpacked(const PackedLight& packed, size_t probes = kProbes) {
  std::vector<std::vector<float>> light;
  const FileResult result = unpackGridLight(packed, std::vector<uint32_t>(probes, kFreeSpace), 1, &light);
  EXPECT_TRUE(result.ok()) << result.detail;
  return light.at(0);
}

// Of irradiance from everywhere, by sums over directions: what the header says of errors, in another way.
double irradianceError(const float* from, const float* to) {
  double off = 0.0, whole = 0.0;
  const int turns = 24, heights = 24;
  for (int h = 0; h < heights; ++h) {
    for (int t = 0; t < turns; ++t) {
      const double z = -1.0 + (2.0 * h + 1.0) / heights, turn = 6.283185307179586 * t / turns, r = std::sqrt(1.0 - z * z);
      const auto x = static_cast<float>(r * std::cos(turn)), y = static_cast<float>(r * std::sin(turn));
      const auto a = shIrradiance(from, x, y, static_cast<float>(z)), b = shIrradiance(to, x, y, static_cast<float>(z));
      for (size_t c = 0; c < kShChannels; ++c) off += (a[c] - b[c]) * (a[c] - b[c]), whole += a[c] * a[c];
    }
  }
  return std::sqrt(off / whole);
}

TEST(PackedLight, KeepsTheErrorThatIsAskedFor) {
  const std::vector<float> light = lampLight(1);
  size_t before = std::numeric_limits<size_t>::max();
  for (const double error : {0.005, 0.01, 0.02, 0.05, 0.1, 0.3}) {
    PackedLight packed;
    const LightPacking packing = packLight(light, error, &packed);
    EXPECT_LE(packing.error, error);
    const size_t bytes = codedRecords(packed, std::vector<RecordsBefore>(kProbes, {kNoRecord, kNoRecord, kNoRecord})).size();
    EXPECT_LT(bytes, before) << error;
    before = bytes;
    const std::vector<float> after = unpacked(packed);
    double squares = 0.0, worst = 0.0;
    for (size_t probe = 0; probe < kProbes; ++probe) {
      const double off = irradianceError(&light[probe * kShFloats], &after[probe * kShFloats]);
      squares += off * off;
      worst = std::max(worst, off);
    }
    // the sums over directions are within a hundredth
    EXPECT_NEAR(std::sqrt(squares / kProbes), packing.error, 0.01 * packing.error);
    EXPECT_NEAR(worst, packing.worst, 0.05 * packing.worst);
  }
}

TEST(PackedLight, HoldsAnyLightThatAGridMayHave) {
  for (const float value : {1e-30f, -1e-10f, 65504.0f, -kMaxGridLight, kMaxGridLight}) {
    const std::vector<float> light(2 * kShFloats, value);
    PackedLight packed;
    packLight(light, 0.001, &packed);
    for (const float after : unpacked(packed, 2)) EXPECT_NEAR(after, value, 2e-3 * std::abs(double{value}));
  }
}

TEST(PackedLight, IsDarkWhereNothingShines) {
  std::vector<float> light = lampLight(3);
  PackedLight packed;
  std::fill_n(light.begin(), 5 * kShFloats, 0.0f);
  light[3 * kShFloats] = 1e-20f;
  const LightPacking packing = packLight(light, 0.02, &packed);
  EXPECT_EQ(packing.too_dark, 1u);
  const std::vector<float> after = unpacked(packed);
  EXPECT_TRUE(std::all_of(after.begin(), after.begin() + 5 * kShFloats, [](float value) { return value == 0.0f; }));
  EXPECT_NE(after[5 * kShFloats], 0.0f);
  const std::vector<float> dark(kProbes * kShFloats, 0.0f);
  EXPECT_EQ(packLight(dark, 0.02, &packed).error, 0.0);
  EXPECT_EQ(lightWords(packed), 0);
  EXPECT_EQ(unpacked(packed), dark);
  EXPECT_EQ(packLight({}, 0.02, &packed).error, 0.0);
  EXPECT_TRUE(unpacked(packed, 0).empty());
}

}  // namespace
}  // namespace nlg
