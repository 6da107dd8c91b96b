// Weights files that mean harm, as tests/fuzz found them.
#include <gtest/gtest.h>

#include <clocale>

#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

WeightsResult resultWith(const std::string& key, const std::string& value) {
  WeightsFile file = weightsFromGenerator(sampleGenerator(Representation::tentMlp(), 24, 3, 1));
  file.metadata[key] = value;
  GeneratorData data;
  return generatorFromWeights(file, &data);
}

TEST(HostileWeights, AreRefusedInOneShortLineWhateverTheirTextsHold) {
  for (const char* key : {"pattern_hash", "representation", "version", "representation_slope", "width", "class_count.3"}) {
    const WeightsResult result = resultWith(key, "\n\x1b[2J" + std::string(100000, 'x'));
    EXPECT_FALSE(result.ok()) << key;
    EXPECT_LT(result.detail.size(), 200u) << key;
    for (const char c : result.detail) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << key << ": " << result.detail;
  }
}

TEST(HostileWeights, HaveNumbersThatEndWithTheirText) {
  for (const std::string& value :
       {std::string("24\0", 3), std::string("24\0hidden", 9), std::string(" 24"), std::string("24 ")}) {
    EXPECT_EQ(resultWith("width", value).status, WeightsStatus::value_out_of_range) << testing::PrintToString(value);
  }
}

// In a locale that writes 0,5 for a half; skipped where none of these is installed.
TEST(Weights, AreReadAlikeInEveryLocale) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  const char* chosen = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "sv_SE.UTF-8"}) {
    if (chosen == nullptr) chosen = std::setlocale(LC_NUMERIC, name);
  }
  if (chosen == nullptr) GTEST_SKIP() << "no locale with a decimal comma is installed";
  const WeightsResult result = resultWith("generator_slope", "0.05");
  std::setlocale(LC_NUMERIC, before.c_str());
  EXPECT_TRUE(result.ok()) << result.detail;
}

}  // namespace
}  // namespace nlg
