#include "runtime_eval/light_grid/light_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/light_grid/light_grid.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr size_t kProbes = 500;

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

std::vector<float> rounded(LightForm form, std::vector<float> light) {
  const FileResult result = roundLight(form, &light);
  EXPECT_TRUE(result.ok()) << result.detail;
  return light;
}

PackedLight packed(LightForm form, const std::vector<float>& light) {
  PackedLight result;
  EXPECT_TRUE(packLight(form, light, &result).ok());
  return result;
}

// What numbers near 0 may be off by: half a step of the smallest halves over the common scale.
double leastStep(const std::vector<float>& light) {
  float largest = 0.0f;
  for (size_t i = 0; i < light.size(); i += kShFloats) largest = std::max({largest, light[i], light[i + 1], light[i + 2]});
  return 0x1p-34 * double{largest};
}

float largestOf(const float* values, int count) {
  float largest = 0.0f;
  for (int i = 0; i < count; ++i) largest = std::max(largest, std::abs(values[i]));
  return largest;
}

TEST(LightForm, HasANameThatFindsIt) {
  for (const LightForm form : kLightForms) {
    LightForm found = LightForm::none;
    ASSERT_TRUE(findLightForm(lightFormName(form), &found));
    EXPECT_EQ(found, form);
  }
  LightForm found = LightForm::none;
  EXPECT_FALSE(findLightForm("sh3", &found));
}

TEST(LightForm, TakesTheBytesItSays) {
  for (const LightForm form : kLightForms) {
    const PackedLight form_of = packed(form, lampLight(1));
    const size_t bytes = form_of.halves.size() * sizeof(Half) + form_of.steps.size();
    EXPECT_EQ(bytes, kProbes * lightFormBytes(form)) << lightFormName(form);
  }
}

TEST(LightForm, OfHalvesIsOffByARounding) {
  const std::vector<float> light = lampLight(2), after = rounded(LightForm::sh2_float16, light);
  const double absolute = leastStep(light);
  for (size_t i = 0; i < light.size(); ++i)
    ASSERT_NEAR(after[i], light[i], std::max(absolute, 0x1p-11 * std::abs(double{light[i]}))) << i;
}

TEST(LightForm, OfBytesIsOffByHalfAStep) {
  const std::vector<float> light = lampLight(3), after = rounded(LightForm::sh2_8bit, light);
  double squares = 0.0;
  int counted = 0;
  for (size_t probe = 0; probe < kProbes; ++probe) {
    const float* from = &light[probe * kShFloats];
    const float* to = &after[probe * kShFloats];
    const double largest = double{largestOf(from + kShChannels, kShFloats - kShChannels)};
    for (int i = 0; i < kShFloats; ++i) {
      // half a step of the largest, itself rounded to a half
      const double bound = i < kShChannels ? std::max(leastStep(light), 0x1p-11 * std::abs(double{from[i]}))
                                           : std::max(0x1p9 * leastStep(light), largest / 254 * (1 + 0x1p-10));
      ASSERT_NEAR(to[i], from[i], bound) << "probe " << probe << ", " << i;
    }
    if (largest < 0x1p20 * leastStep(light)) continue;
    for (const float z : {-1.0f, 1.0f}) {
      const double off = double{shIrradiance(from, 0, 0, z)[0]} - shIrradiance(to, 0, 0, z)[0];
      squares += off * off / (largest * largest);
      ++counted;
    }
  }
  // Irradiance from above takes 1.023 of one coefficient and .495 of another, each off by 1 / 254 / sqrt(3) of the largest in the
  // mean, and of Y00, up to 4 times the largest here, .886, off by 2^-11 / sqrt(3): .0026 and .001
  EXPECT_GT(counted, 200);
  EXPECT_LT(std::sqrt(squares / counted), 0.003);
}

TEST(LightForm, OfOrderOneKeepsOrderOneAlone) {
  const std::vector<float> light = lampLight(4), after = rounded(LightForm::sh1_float16, light),
                           all = rounded(LightForm::sh2_float16, light);
  for (size_t i = 0; i < light.size(); ++i) ASSERT_EQ(after[i], i % kShFloats < 4 * kShChannels ? all[i] : 0.0f) << i;
}

// Light of one lamp: all of order 2 lies along its direction.
TEST(LightForm, ZonalHoldsOneLampWhole) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const double z = random.uniform(-1.0, 1.0), turn = random.uniform(0.0, 6.283185307179586), r = std::sqrt(1.0 - z * z);
    const std::array<float, kShCount> basis =
        shBasis(static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)), static_cast<float>(z));
    std::vector<float> light(kShFloats);
    for (int i = 0; i < kShFloats; ++i)
      light[static_cast<size_t>(i)] = basis[i / kShChannels] * static_cast<float>(1 + i % kShChannels);
    const std::vector<float> after = rounded(LightForm::zh3_float16, light);
    // the direction turns by two roundings of half, order 2 changes by at most 3 times that, and is rounded itself
    for (size_t i = 0; i < light.size(); ++i)
      ASSERT_NEAR(after[i], light[i], 3.0 * 8 * 0x1p-11) << "trial " << trial << ", " << i;
  }
}

TEST(LightForm, ZonalIsTheNearestAlongItsDirection) {
  // no other coefficient along the main direction is nearer to order 2
  const std::vector<float> light = lampLight(6), zonal = rounded(LightForm::zh3_float16, light);
  for (size_t probe = 0; probe < kProbes; ++probe) {
    const float* from = &light[probe * kShFloats];
    const float* to = &zonal[probe * kShFloats];
    for (int c = 0; c < kShChannels; ++c) {
      double along = 0.0, length = 0.0, off = 0.0;
      for (int i = 4; i < kShCount; ++i) {
        const double f = from[i * kShChannels + c], t = to[i * kShChannels + c];
        along += (f - t) * t;
        length += t * t;
        off += f * f;
      }
      // what is left is perpendicular to what is held, but for the rounding of the one coefficient and of the direction
      ASSERT_LE(std::abs(along), (8 * 0x1p-11 * std::sqrt(off) + leastStep(light)) * std::sqrt(length)) << "probe " << probe;
    }
  }
}

TEST(LightForm, HoldsAnyLightThatAGridMayHave) {
  for (const LightForm form : kLightForms) {
    if (form == LightForm::none) continue;
    for (const float value : {0.0f, 1e-45f, 1e-30f, -1e-10f, 65504.0f, -kMaxGridLight, kMaxGridLight}) {
      const std::vector<float> light(2 * kShFloats, value), after = rounded(form, light);
      ASSERT_EQ(after.size(), light.size()) << lightFormName(form) << ": " << value;
      for (int i = 0; i < kShChannels; ++i)
        EXPECT_NEAR(after[static_cast<size_t>(i)], value, 1e-3 * std::abs(double{value}) + 1e-44) << lightFormName(form);
    }
  }
}

TEST(LightForm, PacksWhatItUnpackedToTheSameNumbers) {
  for (const LightForm form : kLightForms) {
    if (form == LightForm::none) continue;
    for (uint64_t seed = 10; seed < 20; ++seed) {
      const std::vector<float> light = lampLight(seed);
      const PackedLight first = packed(form, light), second = packed(form, rounded(form, light));
      EXPECT_EQ(first.scale, second.scale) << lightFormName(form);
      EXPECT_TRUE(first.halves == second.halves) << lightFormName(form);
      EXPECT_TRUE(first.steps == second.steps) << lightFormName(form);
    }
  }
}

TEST(LightForm, RefusesWhatIsNoLight) {
  std::vector<float> light(kShFloats, 1.0f);
  light[20] = light[5] = 300.0f;  // of a mean of 1, over which float16 ends at 65504 / 512 at least
  PackedLight none;
  for (const LightForm form : {LightForm::sh2_float16, LightForm::sh2_8bit, LightForm::zh3_float16})
    EXPECT_EQ(packLight(form, light, &none).status, FileStatus::value_out_of_range) << lightFormName(form);
  EXPECT_TRUE(none.halves.empty() && none.steps.empty());
  light[5] = 1.0f;
  EXPECT_TRUE(packLight(LightForm::sh1_float16, light, &none).ok());
}

TEST(LightForm, RefusesWhatNoFormGives) {
  const PackedLight good = packed(LightForm::sh2_8bit, lampLight(7));
  const auto statusOf = [&](auto spoil) {
    PackedLight bad = good;
    spoil(bad);
    std::vector<float> light{1.0f};
    const FileResult result = unpackLight(LightForm::sh2_8bit, bad, kProbes, &light);
    EXPECT_EQ(result.ok(), !light.empty());
    EXPECT_EQ(result.ok(), result.detail.empty());
    return result.status;
  };
  EXPECT_EQ(statusOf([](PackedLight&) {}), FileStatus::ok);
  EXPECT_EQ(statusOf([](PackedLight& p) { p.halves.pop_back(); }), FileStatus::tensor_unexpected);
  EXPECT_EQ(statusOf([](PackedLight& p) { p.steps.clear(); }), FileStatus::tensor_unexpected);
  EXPECT_EQ(statusOf([](PackedLight& p) { p.steps[5] = -128; }), FileStatus::value_out_of_range);
  EXPECT_EQ(statusOf([](PackedLight& p) { p.halves[5].bits = 0xfc00; }), FileStatus::value_not_finite);
  for (const float scale : {0.0f, -1.0f, 1.5f, 8388608.0f, 1e-36f, std::numeric_limits<float>::infinity()})
    EXPECT_EQ(statusOf([=](PackedLight& p) { p.scale = scale; }), FileStatus::value_out_of_range) << scale;
}

}  // namespace
}  // namespace nlg
