
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <locale>
#include <thread>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/runtime_eval/system_calls.h"

namespace nlg {
namespace {

std::vector<float> generateAll(const Generator& generator, const std::vector<StoredFunction>& functions, int count) {
  GeneratorScratch scratch(generator);
  std::vector<float> theta(size_t(count) * generator.representation().thetaCount());
  generator.generate(functions.data(), count, theta.data(), &scratch);
  return theta;
}

// Coefficients: 1028 roundings of terms whose magnitudes add up to at most |class| |row| / deviation <= 32 * 3 / 0.2;
// layers of random signs keep errors near their input's, and the output's scale is at most 0.2.
constexpr double kFloatBound = 1028 * kFloatRounding * (32 * 3 / 0.2) * 0.2;

// Small networks that have every kind of layer: skips (48 = 48), a first layer as wide as its input (25 coefficients), one layer
// alone; for networks and a product field, on ragged batches.
struct RaggedCase {
  int width, layers, count;
  Representation representation = Representation::mlp();
  GeneratorInput input = GeneratorInput::coefficients;
};
const RaggedCase kRaggedCases[] = {{48, 4, 1},
                                   {25, 3, 2},
                                   {48, 3, 7},
                                   {33, 3, 8},
                                   {32, 2, 9},
                                   {7, 3, 31},
                                   {113, 3, 95},
                                   {48, 1, 96},
                                   {48, 3, 97},
                                   {16, 3, 257},
                                   {48, 3, 1, Representation::productField(5)},
                                   {25, 3, 9, Representation::productField(5)},
                                   {16, 2, 97, Representation::productField(5)},
                                   {25, 3, 9, Representation::code(sampleDictionary(5, 64, 1))},
                                   {25, 4, 9, Representation::mlp(), GeneratorInput::samples},
                                   {48, 3, 97, Representation::productField(5), GeneratorInput::samples}};

std::string describe(const RaggedCase& c) {
  return std::string(representationName(c.representation)) + ", width " + std::to_string(c.width) + ", layers " +
         std::to_string(c.layers) + ", " + std::to_string(c.count) + " functions";
}

FileStatus statusOf(const WeightsFile& file) {
  GeneratorData data;
  const FileResult result = generatorFromWeights(file, &data);
  EXPECT_EQ(result.ok(), result.detail.empty()) << result.detail;
  return result.status;
}

// The status of a good file after a change.
template <class Change>
FileStatus statusAfter(const Change& change) {
  WeightsFile file = weightsFromGenerator(sampleGenerator(Representation::tentMlp(0.01f), 24, 3, 1));
  change(file);
  return statusOf(file);
}

TEST(Generator, EqualsTheReferenceOnRaggedCountsAndEveryTarget) {
  const SampleFunctions samples = sampleFunctions(257);
  const std::vector<StoredFunction> functions = samples.views();
  for (const RaggedCase& c : kRaggedCases) {
    const GeneratorData data = sampleGenerator(c.representation, c.width, c.layers, 5, c.input);
    const int theta_count = data.representation.thetaCount();
    std::vector<std::vector<double>> expected;
    for (int n = 0; n < c.count; ++n) expected.push_back(generateReference(data, functions[n]));
    forEachTarget([&] {
      const std::vector<float> theta = generateAll(Generator(data), functions, c.count);
      for (int n = 0; n < c.count; ++n) {
        for (int k = 0; k < theta_count; ++k) {
          ASSERT_NEAR(theta[size_t(n) * theta_count + k], expected[n][k], kFloatBound)
              << describe(c) << ": function " << n << ", theta " << k;
        }
      }
    });
  }
}

TEST(Generator, GivesAFunctionTheSameBitsInEveryBatch) {
  constexpr int kCount = 257;
  const SampleFunctions samples = sampleFunctions(kCount);
  const std::vector<StoredFunction> functions = samples.views();
  for (const GeneratorInput input : {GeneratorInput::coefficients, GeneratorInput::samples}) {
    const Representation representation =
        input == GeneratorInput::samples ? Representation::mlp() : Representation::productField(5);
    // 600 inputs are more than one block of either product
    GeneratorData data = sampleGenerator(representation, 600, 3, 6, input);
    const int theta_count = data.representation.thetaCount();
    const Generator generator(data);
    GeneratorScratch scratch(generator);
    forEachTarget([&] {
      if (chosenSimdTarget() == "scalar" && representation.isField()) return;  // slow, and the same path
      std::vector<float> together(size_t(kCount) * theta_count), apart(together.size());
      generator.generate(functions.data(), kCount, together.data(), &scratch);
      // batches that end in the rows left over from tiles of every size
      const int batches[] = {1, 2, 3, 5, 6, 7, 11, 12, 13, 23, 31, 96};
      for (int n = 0, b = 0; n < kCount; ++b) {
        const int batch = std::min(batches[b % 12], kCount - n);
        generator.generate(&functions[n], batch, &apart[size_t(n) * theta_count], &scratch);
        n += batch;
      }
      EXPECT_EQ(together, apart);
    });
  }
}

TEST(Generator, GivesTheSameBitsOnSeveralThreads) {
  constexpr int kCount = 100, kThreads = 4;
  const SampleFunctions samples = sampleFunctions(kCount);
  const std::vector<StoredFunction> functions = samples.views();
  const GeneratorData data = sampleGenerator({}, 40, 3, 16);
  const Generator generator(data);
  const std::vector<float> expected = generateAll(generator, functions, kCount);
  std::vector<float> theta(expected.size());
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      GeneratorScratch scratch(generator);
      for (int n = t; n < kCount; n += kThreads) {
        generator.generate(&functions[n], 1, &theta[size_t(n) * ThetaLayout::count], &scratch);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(theta, expected);
}

[[noreturn]] void loadUnder(const char* simd) {
  setEnvironment("NLG_SIMD", simd);
  Generator generator;
  const FileResult result = Generator::load("/nowhere/weights", &generator);
  std::fprintf(stderr, "%s\n", result.detail.c_str());
  std::_Exit(static_cast<int>(result.status));
}

TEST(GeneratorDeathTest, IsNotLoadedUnderATargetThatIsNotThere) {
  EXPECT_EXIT(loadUnder("avx9"), testing::ExitedWithCode(static_cast<int>(FileStatus::simd_unavailable)),
              "NLG_SIMD: SIMD target 'avx9' is unknown; expected one of ");
  // past the target: the file is missing
  EXPECT_EXIT(loadUnder("scalar"), testing::ExitedWithCode(static_cast<int>(FileStatus::cannot_open)), "");
}

TEST(Generator, LoadsWhatWasSaved) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_generator_" + std::to_string(::getpid()))).string();
  const GeneratorData data = sampleGenerator(Representation::tentMlp(0.02f), 24, 3, 8);
  std::ofstream(path, std::ios::binary) << serializeWeights(weightsFromGenerator(data));
  Generator generator;
  const FileResult result = Generator::load(path, &generator);
  ASSERT_TRUE(result.ok()) << result.detail;
  EXPECT_TRUE(generator.representation().tentFactor());
  EXPECT_EQ(generator.representation().slope, 0.02f);
  const SampleFunctions samples = sampleFunctions(1);
  const std::vector<StoredFunction> functions = samples.views();
  const std::vector<float> theta = generateAll(Generator(data), functions, 1);
  EXPECT_EQ(generateAll(generator, functions, 1), theta);

  // the same from its bytes
  Generator parsed;
  const FileResult of_bytes = Generator::parse(serializeWeights(weightsFromGenerator(data)), &parsed);
  ASSERT_TRUE(of_bytes.ok()) << of_bytes.detail;
  EXPECT_EQ(generateAll(parsed, functions, 1), theta);

  // a failing load leaves the generator as it was
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_EQ(Generator::load(path, &generator).status, FileStatus::too_short);
  std::filesystem::remove(path);
  EXPECT_EQ(Generator::load(path, &generator).status, FileStatus::cannot_open);
  EXPECT_EQ(generateAll(generator, functions, 1), theta);
}

TEST(GeneratorWeights, RoundTrip) {
  for (const int layers : {1, 2, 5}) {
    const GeneratorData data =
        sampleGenerator(layers % 2 == 0 ? Representation::tentMlp(0.03f) : Representation::mlp(0.03f), 24, layers, 9);
    GeneratorData read;
    const FileResult result = generatorFromWeights(weightsFromGenerator(data), &read);
    ASSERT_TRUE(result.ok()) << result.detail;
    EXPECT_EQ(read.representation.tentFactor(), data.representation.tentFactor());
    EXPECT_EQ(read.representation.slope, data.representation.slope);
    EXPECT_EQ(read.slope, data.slope);
    EXPECT_EQ(read.basis.class_count, data.basis.class_count);
    EXPECT_EQ(read.basis.mean, data.basis.mean);
    EXPECT_EQ(read.basis.components, data.basis.components);
    EXPECT_EQ(read.basis.deviation, data.basis.deviation);
    EXPECT_EQ(read.theta0, data.theta0);
    EXPECT_EQ(read.output_scale, data.output_scale);
    ASSERT_EQ(read.layers.size(), data.layers.size());
    for (size_t l = 0; l < data.layers.size(); ++l) {
      EXPECT_EQ(read.layers[l].input_count, data.layers[l].input_count) << "layer " << l;
      EXPECT_EQ(read.layers[l].output_count, data.layers[l].output_count) << "layer " << l;
      EXPECT_EQ(read.layers[l].weight, data.layers[l].weight) << "layer " << l;
      EXPECT_EQ(read.layers[l].bias, data.layers[l].bias) << "layer " << l;
    }
  }
}

TEST(GeneratorWeights, RoundTripWithTheirDictionary) {
  for (const CodeKind& kind : kCodes) {
    for (const int resolution : {3, 5, 7, 9}) {
      const GeneratorData data = sampleGenerator(Representation::code(sampleDictionary(resolution, kind.count, 2)), 24, 2, 3);
      Generator generator;
      const FileResult result = Generator::parse(serializeWeights(weightsFromGenerator(data)), &generator);
      ASSERT_TRUE(result.ok()) << result.detail;
      const Representation& read = generator.representation();
      EXPECT_STREQ(representationName(read), kind.name);
      EXPECT_EQ(read.resolution, resolution);
      ASSERT_NE(read.dictionary, nullptr);
      EXPECT_EQ(read.dictionary->data(), data.representation.dictionary->data()) << kind.name << ", " << resolution;
      EXPECT_FALSE(generator.exactLastLayer());
    }
  }
}

// A reader of version 1 would take components of samples for principal ones: it is told to refuse them.
TEST(GeneratorWeights, OfSamplesAreOfVersionTwo) {
  const GeneratorData data = sampleGenerator(Representation::mlp(), 24, 2, 9, GeneratorInput::samples);
  WeightsFile file = weightsFromGenerator(data);
  EXPECT_EQ(file.metadata["version"], "2");
  GeneratorData read;
  const FileResult result = generatorFromWeights(file, &read);
  ASSERT_TRUE(result.ok()) << result.detail;
  EXPECT_EQ(read.basis.input, GeneratorInput::samples);
  EXPECT_EQ(read.basis.class_count, data.basis.class_count);
  EXPECT_EQ(read.basis.components, data.basis.components);
  EXPECT_TRUE(Generator(read).readsSamples());
  file.metadata["input"] = "moments";
  EXPECT_EQ(statusOf(file), FileStatus::value_out_of_range);
  file.metadata.erase("input");
  EXPECT_EQ(statusOf(file), FileStatus::tensor_missing);
}

TEST(GeneratorWeights, RefuseForeignPatternsAndNewerVersions) {
  const auto statusWith = [](const char* key, const char* value) {
    return statusAfter([&](WeightsFile& f) { f.metadata[key] = value; });
  };
  EXPECT_EQ(statusWith("a note", "for people"), FileStatus::ok);
  EXPECT_EQ(statusWith("pattern_hash", "0123456789abcdef"), FileStatus::pattern_unknown);
  EXPECT_EQ(statusWith("pattern_hash", ""), FileStatus::pattern_unknown);
  EXPECT_EQ(statusWith("version", "3"), FileStatus::version_unknown);
  for (const char* version : {"0", "-1", "1.5", "", "one", "nan"})
    EXPECT_EQ(statusWith("version", version), FileStatus::value_out_of_range) << version;
}

// 0,5 for a half, as an engine's global locale may have it.
struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(GeneratorWeights, AreReadAlikeInEveryLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const FileStatus half = statusAfter([](WeightsFile&f) { f.metadata["generator_slope"] = "0.05"; }),
                   wide = statusAfter([](WeightsFile&f) { f.metadata["width"] = "1.024"; });
  std::locale::global(before);
  EXPECT_EQ(half, FileStatus::ok);
  EXPECT_EQ(wide, FileStatus::value_out_of_range);
}

}  // namespace
}  // namespace nlg
