
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

template <class Sample>
std::vector<float> generateAll(const GeneratorData& data, const std::vector<Sample>& phi, int count) {
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  std::vector<float> theta(size_t(count) * data.representation.thetaCount());
  generator.generate(phi.data(), count, theta.data(), &scratch);
  return theta;
}

std::vector<double> referenceOf(const GeneratorData& data, const uint8_t* phi) {
  return generateReference(data, unquantised(phi).data());
}

// Coefficients: 1028 roundings of terms whose magnitudes add up to at most |class| |row| / deviation <= 32 * 3 / 0.2;
// layers of random signs keep errors near their input's, and the output's scale is at most 0.2.
constexpr double kFloatBound = 1028 * kFloatRounding * (32 * 3 / 0.2) * 0.2;

// Small networks that have every kind of layer: skips (48 = 48), a first layer as wide as its input (25 coefficients), one layer
// alone; for networks and a product field, on ragged batches.
struct RaggedCase {
  int width, layers, count;
  Representation representation = Representation::mlp();
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
                                   {25, 3, 9, Representation::code(sampleDictionary(5, 64, 1))}};

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
  const std::vector<uint8_t> phi = sampleFunctions(257);
  for (const RaggedCase& c : kRaggedCases) {
    const GeneratorData data = sampleGenerator(c.representation, c.width, c.layers, 5);
    const int theta_count = data.representation.thetaCount();
    std::vector<std::vector<double>> expected;
    for (int n = 0; n < c.count; ++n) expected.push_back(referenceOf(data, &phi[size_t(n) * kSupportPointCount]));
    forEachTarget([&] {
      const std::vector<float> theta = generateAll(data, phi, c.count);
      for (int n = 0; n < c.count; ++n) {
        for (int k = 0; k < theta_count; ++k) {
          ASSERT_NEAR(theta[size_t(n) * theta_count + k], expected[n][k], kFloatBound)
              << describe(c) << ": function " << n << ", theta " << k;
        }
      }
    });
  }
}

TEST(Generator, TakesFloatSamples) {
  const GeneratorData data = sampleGenerator({}, 48, 3, 13);
  Random random(14);
  std::vector<float> phi;
  for (int p = 0; p < 2 * kSupportPointCount; ++p) phi.push_back(static_cast<float>(random.uniform(0.0, 1.0)));
  std::vector<std::vector<double>> expected;
  for (int n = 0; n < 2; ++n) {
    const std::vector<double> exact(phi.begin() + n * kSupportPointCount, phi.begin() + (n + 1) * kSupportPointCount);
    expected.push_back(generateReference(data, exact.data()));
  }
  forEachTarget([&] {
    const std::vector<float> theta = generateAll(data, phi, 2);
    for (int n = 0; n < 2; ++n) {
      // four roundings a class more than bytes have
      for (int k = 0; k < ThetaLayout::count; ++k) {
        ASSERT_NEAR(theta[n * ThetaLayout::count + k], expected[n][k], kFloatBound * 1032 / 1028) << n << ", theta " << k;
      }
    }
  });
}

TEST(Generator, GivesAFunctionTheSameBitsInEveryBatch) {
  constexpr int kCount = 257;
  const std::vector<uint8_t> phi = sampleFunctions(kCount);
  for (const Representation& representation : {Representation::mlp(), Representation::productField(5)}) {
    // 600 inputs are more than one block of either product
    GeneratorData data = sampleGenerator(representation, 600, 3, 6);
    const int theta_count = data.representation.thetaCount();
    const Generator generator(data);
    GeneratorScratch scratch(generator);
    forEachTarget([&] {
      if (chosenSimdTarget() == "scalar" && representation.isField()) return;  // slow, and the same path
      std::vector<float> together(size_t(kCount) * theta_count), apart(together.size());
      generator.generate(phi.data(), kCount, together.data(), &scratch);
      // batches that end in the rows left over from tiles of every size
      const int batches[] = {1, 2, 3, 5, 6, 7, 11, 12, 13, 23, 31, 96};
      for (int n = 0, b = 0; n < kCount; ++b) {
        const int batch = std::min(batches[b % 12], kCount - n);
        generator.generate(&phi[size_t(n) * kSupportPointCount], batch, &apart[size_t(n) * theta_count], &scratch);
        n += batch;
      }
      EXPECT_EQ(together, apart);
    });
  }
}

TEST(Generator, GivesTheSameBitsOnSeveralThreads) {
  constexpr int kCount = 100, kThreads = 4;
  const std::vector<uint8_t> phi = sampleFunctions(kCount);
  const GeneratorData data = sampleGenerator({}, 40, 3, 16);
  const Generator generator(data);
  const std::vector<float> expected = generateAll(data, phi, kCount);
  std::vector<float> theta(expected.size());
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      GeneratorScratch scratch(generator);
      for (int n = t; n < kCount; n += kThreads) {
        generator.generate(&phi[size_t(n) * kSupportPointCount], 1, &theta[size_t(n) * ThetaLayout::count], &scratch);
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
  const std::vector<uint8_t> phi = sampleFunctions(1);
  GeneratorScratch scratch(generator);
  std::vector<float> theta(ThetaLayout::count);
  generator.generate(phi.data(), 1, theta.data(), &scratch);
  EXPECT_EQ(theta, generateAll(data, phi, 1));

  // the same from its bytes
  Generator parsed;
  const FileResult of_bytes = Generator::parse(serializeWeights(weightsFromGenerator(data)), &parsed);
  ASSERT_TRUE(of_bytes.ok()) << of_bytes.detail;
  GeneratorScratch parsed_scratch(parsed);
  std::vector<float> parsed_theta(ThetaLayout::count);
  parsed.generate(phi.data(), 1, parsed_theta.data(), &parsed_scratch);
  EXPECT_EQ(parsed_theta, theta);

  // a failing load leaves the generator as it was
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_EQ(Generator::load(path, &generator).status, FileStatus::too_short);
  std::filesystem::remove(path);
  EXPECT_EQ(Generator::load(path, &generator).status, FileStatus::cannot_open);
  std::vector<float> again(ThetaLayout::count);
  generator.generate(phi.data(), 1, again.data(), &scratch);
  EXPECT_EQ(again, theta);
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

WeightsFile weightsOfACode() {
  return weightsFromGenerator(sampleGenerator(Representation::code(sampleDictionary(5, 32, 1)), 24, 3, 1));
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

TEST(GeneratorWeights, RefuseEveryMissingOrWrongPart) {
  for (const WeightsFile& whole : {weightsFromGenerator(sampleGenerator({}, 24, 3, 1)), weightsOfACode()}) {
    ASSERT_EQ(statusOf(whole), FileStatus::ok);
    for (const auto& [key, ignored] : whole.metadata) {
      WeightsFile file = whole;
      file.metadata.erase(key);
      EXPECT_EQ(statusOf(file), FileStatus::tensor_missing) << "metadata " << key;
    }
    for (const auto& [name, ignored] : whole.tensors) {
      WeightsFile file = whole;
      file.tensors.erase(name);
      EXPECT_EQ(statusOf(file), FileStatus::tensor_missing) << "tensor " << name;
      WeightsTensor longer = whole.tensors.at(name), deeper = longer;
      longer.values.insert(longer.values.end(), longer.values.size() / longer.shape[0], 0.0f);
      ++longer.shape[0];
      deeper.shape.push_back(1);
      for (const WeightsTensor& other : {longer, deeper, WeightsTensor{{0}, {}}}) {
        file.tensors[name] = other;
        EXPECT_EQ(statusOf(file), FileStatus::tensor_unexpected) << name << ": " << testing::PrintToString(other.shape);
      }
      for (const float value : {NAN, INFINITY, -INFINITY}) {
        file = whole;
        file.tensors[name].values.back() = value;
        EXPECT_EQ(statusOf(file), FileStatus::value_not_finite) << name << ": " << value;
      }
    }
  }
}

// DictionaryData.IsRefusedWithTheReason has the numbers themselves.
TEST(GeneratorWeights, RefuseDictionariesOutOfRange) {
  const auto statusWith = [](const auto& change) {
    WeightsFile file = weightsOfACode();
    change(file);
    return statusOf(file);
  };
  EXPECT_EQ(statusWith([](WeightsFile& f) { f.metadata["dictionary_resolution"] = "5.5"; }), FileStatus::value_out_of_range);
  EXPECT_EQ(statusWith([](WeightsFile& f) { f.metadata["dictionary_resolution"] = "9"; }), FileStatus::tensor_unexpected);
  // 4³ nodes, all there
  EXPECT_EQ(statusWith([](WeightsFile& f) {
              f.metadata["dictionary_resolution"] = "4";
              f.tensors["dictionary.nodes"] = {{33, 4, 4, 4}, std::vector<float>(33 * 64), WeightsDtype::float16};
            }),
            FileStatus::value_out_of_range);
  EXPECT_EQ(statusWith([](WeightsFile& f) { f.metadata["representation"] = "code64"; }), FileStatus::tensor_unexpected);
  // nodes and exponents are whole numbers of a byte
  for (const char* name : {"dictionary.nodes", "dictionary.exponents"}) {
    for (const float value : {0.5f, -128.0f, 1e30f}) {
      EXPECT_EQ(statusWith([&](WeightsFile& f) { f.tensors[name].values[7] = value; }), FileStatus::value_out_of_range)
          << name << ": " << value;
    }
  }
  // a code has no last layer that could be solved
  EXPECT_EQ(statusWith([](WeightsFile& f) { f.metadata["exact_last_layer"] = "1"; }), FileStatus::value_out_of_range);
}

TEST(GeneratorWeights, AreTakenUnchanged) {
  EXPECT_EQ(statusAfter([](WeightsFile&) {}), FileStatus::ok);
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["a note"] = "for people"; }), FileStatus::ok);
}

TEST(GeneratorWeights, RefuseForeignPatternsAndNewerVersions) {
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["pattern_hash"] = "0123456789abcdef"; }), FileStatus::pattern_unknown);
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["pattern_hash"] = ""; }), FileStatus::pattern_unknown);
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["version"] = "2"; }), FileStatus::version_unknown);
  for (const char* version : {"0", "-1", "1.5", "", "one", "nan"}) {
    EXPECT_EQ(statusAfter([&](WeightsFile& f) { f.metadata["version"] = version; }), FileStatus::value_out_of_range) << version;
  }
}

TEST(GeneratorWeights, RefuseMetadataOutOfRange) {
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"representation", {"", "MLP", "pf4", "mlp\n"}}, {"representation_slope", {"0", "1", "-0.01", "nan", "inf", "", "0.01x"}},
      {"generator_slope", {"0", "1", "nan", ""}},      {"layer_count", {"0", "-3", "2.5", "1e9", "99999999999999999999", ""}},
      {"width", {"0", "2.5", "1e9", " 24", "24 "}},    {"class_count.3", {"-1", "1025", "0.5", "many"}}};
  for (const auto& [key, values] : cases) {
    for (const char* value : values) {
      EXPECT_EQ(statusAfter([&](WeightsFile& f) { f.metadata[key] = value; }), FileStatus::value_out_of_range)
          << key << ": " << value;
    }
  }
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["class_count.3"] = "4"; }), FileStatus::tensor_unexpected)
      << "one component more than there is";
  EXPECT_EQ(statusAfter([](WeightsFile& f) {
              for (int c = 0; c < kParityClassCount; ++c) f.metadata["class_count." + std::to_string(c)] = "0";
            }),
            FileStatus::value_out_of_range);
}

TEST(GeneratorWeights, SayWhetherTheLastLayerIsSolved) {
  for (const auto& [representation, is_linear] :
       {std::pair{Representation::tentMlp(), true}, {Representation::productField(3), false}}) {
    GeneratorData data = sampleGenerator(representation, 48, 3, 1), read;
    ASSERT_TRUE(generatorFromWeights(weightsFromGenerator(data), &read).ok());
    EXPECT_FALSE(read.exact_last_layer);
    data.exact_last_layer = true;
    const FileResult result = generatorFromWeights(weightsFromGenerator(data), &read);
    EXPECT_EQ(result.status, is_linear ? FileStatus::ok : FileStatus::value_out_of_range) << result.detail;
    EXPECT_TRUE(!is_linear || read.exact_last_layer);
  }
}

TEST(GeneratorWeights, RefuseDeviationsThatCannotDivide) {
  // the projection divides by them: 1e-40 is a denormal, its reciprocal infinite
  for (const float deviation : {0.0f, -1.0f, 1e-40f}) {
    EXPECT_EQ(statusAfter([&](WeightsFile& f) { f.tensors["basis.deviation"].values[3] = deviation; }),
              FileStatus::value_out_of_range)
        << deviation;
  }
}

TEST(GeneratorWeights, AreRefusedInOneShortLineWhateverTheirTextsHold) {
  for (const char* key : {"pattern_hash", "representation", "version", "representation_slope", "width", "class_count.3"}) {
    WeightsFile file = weightsFromGenerator(sampleGenerator(Representation::tentMlp(), 24, 3, 1));
    file.metadata[key] = "\n\x1b[2J" + std::string(100000, 'x');
    GeneratorData data;
    const FileResult result = generatorFromWeights(file, &data);
    EXPECT_FALSE(result.ok()) << key;
    EXPECT_LT(result.detail.size(), 200u) << key;
    for (const char c : result.detail) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << key << ": " << result.detail;
  }
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
