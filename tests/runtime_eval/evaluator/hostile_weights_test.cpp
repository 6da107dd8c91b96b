// Weights files that mean harm, as tests/fuzz found them.
#include <gtest/gtest.h>

#include <locale>

#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

FileResult resultWith(const std::string& key, const std::string& value) {
  WeightsFile file = weightsFromGenerator(sampleGenerator(Representation::tentMlp(), 24, 3, 1));
  file.metadata[key] = value;
  GeneratorData data;
  return generatorFromWeights(file, &data);
}

TEST(HostileWeights, AreRefusedInOneShortLineWhateverTheirTextsHold) {
  for (const char* key : {"pattern_hash", "representation", "version", "representation_slope", "width", "class_count.3"}) {
    const FileResult result = resultWith(key, "\n\x1b[2J" + std::string(100000, 'x'));
    EXPECT_FALSE(result.ok()) << key;
    EXPECT_LT(result.detail.size(), 200u) << key;
    for (const char c : result.detail) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << key << ": " << result.detail;
  }
}

TEST(HostileWeights, HaveNumbersThatEndWithTheirText) {
  for (const std::string& value :
       {std::string("24\0", 3), std::string("24\0hidden", 9), std::string(" 24"), std::string("24 ")}) {
    EXPECT_EQ(resultWith("width", value).status, FileStatus::value_out_of_range) << testing::PrintToString(value);
  }
}

// 0,5 for a half, as an engine's global locale may have it.
struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Weights, AreReadAlikeInEveryLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const FileResult result = resultWith("generator_slope", "0.05"), wide = resultWith("width", "1.024");
  std::locale::global(before);
  EXPECT_TRUE(result.ok()) << result.detail;
  EXPECT_EQ(wide.status, FileStatus::value_out_of_range) << wide.detail;
}

}  // namespace
}  // namespace nlg
