#include "runtime_eval/evaluator/generator.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

std::vector<float> generateAll(const GeneratorData& data, const std::vector<uint8_t>& phi, int count) {
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  std::vector<float> theta(size_t(count) * ThetaLayout::count);
  generator.generate(phi.data(), count, theta.data(), &scratch);
  return theta;
}

WeightsStatus statusOf(const WeightsFile& file) {
  GeneratorData data;
  const WeightsResult result = generatorFromWeights(file, &data);
  EXPECT_EQ(result.ok(), result.detail.empty()) << result.detail;
  return result.status;
}

// The status of a good file after a change.
template <class Change>
WeightsStatus statusAfter(const Change& change) {
  WeightsFile file = weightsFromGenerator(sampleGenerator(Representation::tentMlp(0.01f), 24, 3, 1));
  change(file);
  return statusOf(file);
}

TEST(Generator, EqualsTheReferenceOnRaggedCountsAndEveryTarget) {
  // widths: skips (48 = 48), a first layer that is as wide as its input (25 coefficients), one layer alone
  struct Case {
    int width, layers, count;
  };
  const std::vector<uint8_t> phi = sampleFunctions(257);
  for (const Case& c : {Case{48, 4, 1}, Case{25, 3, 2}, Case{48, 3, 7}, Case{33, 3, 8}, Case{32, 2, 9}, Case{7, 3, 31},
                        Case{113, 3, 95}, Case{48, 1, 96}, Case{48, 3, 97}, Case{16, 3, 257}}) {
    const GeneratorData data = sampleGenerator({}, c.width, c.layers, 5);
    std::vector<std::vector<double>> expected;
    for (int n = 0; n < c.count; ++n) {
      expected.push_back(generateReference(data, unquantised(&phi[size_t(n) * kSupportPointCount]).data()));
    }
    forEachTarget([&] {
      const std::vector<float> theta = generateAll(data, phi, c.count);
      for (int n = 0; n < c.count; ++n) {
        for (int k = 0; k < ThetaLayout::count; ++k) {
          // Coefficients: 1028 roundings of terms whose magnitudes add up to at most |class| |row| / deviation <= 32 * 3 / 0.2;
          // layers of random signs keep errors near their input's, and the output's scale is at most 0.2
          ASSERT_NEAR(theta[size_t(n) * ThetaLayout::count + k], expected[n][k], 1028 * kFloatRounding * (32 * 3 / 0.2) * 0.2)
              << "width " << c.width << ", layers " << c.layers << ", function " << n << " of " << c.count << ", theta " << k;
        }
      }
    });
  }
}

TEST(Generator, TreatsEveryFunctionOfABatchAlike) {
  const GeneratorData data = sampleGenerator({}, 40, 3, 6);
  const std::vector<uint8_t> phi = sampleFunctions(100);
  forEachTarget([&] {
    const std::vector<float> together = generateAll(data, phi, 100);
    for (int n = 0; n < 100; n += 33) {
      const std::vector<uint8_t> one(phi.begin() + size_t(n) * kSupportPointCount,
                                     phi.begin() + size_t(n + 1) * kSupportPointCount);
      const std::vector<float> alone = generateAll(data, one, 1);
      EXPECT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + size_t(n) * ThetaLayout::count)) << "function " << n;
    }
  });
}

TEST(Generator, YieldsTheta0WhenItsLastLayerIsZero) {
  GeneratorData data = sampleGenerator({}, 40, 3, 7);
  std::fill(data.layers.back().weight.begin(), data.layers.back().weight.end(), 0.0f);
  std::fill(data.layers.back().bias.begin(), data.layers.back().bias.end(), 0.0f);
  const std::vector<float> theta = generateAll(data, sampleFunctions(2), 2);
  for (size_t i = 0; i < theta.size(); ++i) ASSERT_EQ(theta[i], data.theta0[i % ThetaLayout::count]) << i;
}

TEST(Generator, LoadsWhatWasSaved) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_generator_" + std::to_string(::getpid()))).string();
  const GeneratorData data = sampleGenerator(Representation::tentMlp(0.02f), 24, 3, 8);
  std::ofstream(path, std::ios::binary) << serializeWeights(weightsFromGenerator(data));
  Generator generator;
  const WeightsResult result = Generator::load(path, &generator);
  ASSERT_TRUE(result.ok()) << result.detail;
  EXPECT_TRUE(generator.representation().tentFactor());
  EXPECT_EQ(generator.representation().slope, 0.02f);
  const std::vector<uint8_t> phi = sampleFunctions(1);
  GeneratorScratch scratch(generator);
  std::vector<float> theta(ThetaLayout::count);
  generator.generate(phi.data(), 1, theta.data(), &scratch);
  EXPECT_EQ(theta, generateAll(data, phi, 1));

  // a failing load leaves the generator as it was
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_EQ(Generator::load(path, &generator).status, WeightsStatus::too_short);
  std::filesystem::remove(path);
  EXPECT_EQ(Generator::load(path, &generator).status, WeightsStatus::cannot_open);
  std::vector<float> again(ThetaLayout::count);
  generator.generate(phi.data(), 1, again.data(), &scratch);
  EXPECT_EQ(again, theta);
}

TEST(GeneratorWeights, RoundTrip) {
  for (const int layers : {1, 2, 5}) {
    const GeneratorData data =
        sampleGenerator(layers % 2 == 0 ? Representation::tentMlp(0.03f) : Representation::mlp(0.03f), 24, layers, 9);
    GeneratorData read;
    const WeightsResult result = generatorFromWeights(weightsFromGenerator(data), &read);
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

TEST(GeneratorWeights, AreTakenUnchanged) {
  EXPECT_EQ(statusAfter([](WeightsFile&) {}), WeightsStatus::ok);
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["a note"] = "for people"; }), WeightsStatus::ok);
}

TEST(GeneratorWeights, RefuseEveryMissingKeyAndTensor) {
  const WeightsFile whole = weightsFromGenerator(sampleGenerator({}, 24, 3, 1));
  for (const auto& [key, ignored] : whole.metadata) {
    WeightsFile file = whole;
    file.metadata.erase(key);
    EXPECT_EQ(statusOf(file), WeightsStatus::tensor_missing) << "metadata " << key;
  }
  for (const auto& [name, ignored] : whole.tensors) {
    WeightsFile file = whole;
    file.tensors.erase(name);
    EXPECT_EQ(statusOf(file), WeightsStatus::tensor_missing) << "tensor " << name;
  }
}

TEST(GeneratorWeights, RefuseEveryTensorOfAnotherShape) {
  const WeightsFile whole = weightsFromGenerator(sampleGenerator({}, 24, 3, 1));
  for (const auto& [name, ignored] : whole.tensors) {
    WeightsFile file = whole;
    WeightsTensor& tensor = file.tensors[name];
    tensor.values.insert(tensor.values.end(), tensor.values.size() / tensor.shape[0], 0.0f);
    ++tensor.shape[0];
    EXPECT_EQ(statusOf(file), WeightsStatus::tensor_unexpected) << name << " with a row more";
    file = whole;
    file.tensors[name].shape.push_back(1);
    EXPECT_EQ(statusOf(file), WeightsStatus::tensor_unexpected) << name << " with a dimension more";
    file = whole;
    file.tensors[name] = {{0}, {}};
    EXPECT_EQ(statusOf(file), WeightsStatus::tensor_unexpected) << name << " empty";
  }
}

TEST(GeneratorWeights, RefuseNumbersThatAreNotFinite) {
  const WeightsFile whole = weightsFromGenerator(sampleGenerator({}, 24, 3, 1));
  for (const auto& [name, ignored] : whole.tensors) {
    for (const float value : {NAN, INFINITY, -INFINITY}) {
      WeightsFile file = whole;
      file.tensors[name].values.back() = value;
      EXPECT_EQ(statusOf(file), WeightsStatus::value_not_finite) << name << ": " << value;
    }
  }
}

TEST(GeneratorWeights, RefuseForeignPatternsAndNewerVersions) {
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["pattern_hash"] = "0123456789abcdef"; }), WeightsStatus::pattern_unknown);
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["pattern_hash"] = ""; }), WeightsStatus::pattern_unknown);
  EXPECT_EQ(statusAfter([](WeightsFile& f) { f.metadata["version"] = "2"; }), WeightsStatus::version_unknown);
  for (const char* version : {"0", "-1", "1.5", "", "one", "nan"}) {
    EXPECT_EQ(statusAfter([&](WeightsFile& f) { f.metadata["version"] = version; }), WeightsStatus::value_out_of_range)
        << version;
  }
}

TEST(GeneratorWeights, RefuseMetadataOutOfRange) {
  const auto statusWith = [](const std::string& key, const std::string& value) {
    return statusAfter([&](WeightsFile& f) { f.metadata[key] = value; });
  };
  for (const char* name : {"", "MLP", "pf4", "mlp\n"}) {
    EXPECT_EQ(statusWith("representation", name), WeightsStatus::value_out_of_range) << name;
  }
  for (const char* key : {"representation_slope", "generator_slope"}) {
    for (const char* value : {"0", "1", "-0.01", "nan", "inf", "", "0.01x"}) {
      EXPECT_EQ(statusWith(key, value), WeightsStatus::value_out_of_range) << key << ": " << value;
    }
  }
  for (const char* key : {"layer_count", "width"}) {
    for (const char* value : {"0", "-3", "2.5", "1e9", "99999999999999999999", ""}) {
      EXPECT_EQ(statusWith(key, value), WeightsStatus::value_out_of_range) << key << ": " << value;
    }
  }
  for (const char* value : {"-1", "1025", "0.5", "many"}) {
    EXPECT_EQ(statusWith("class_count.3", value), WeightsStatus::value_out_of_range) << value;
  }
  EXPECT_EQ(statusWith("class_count.3", "4"), WeightsStatus::tensor_unexpected);  // one component more than there is
  EXPECT_EQ(statusAfter([](WeightsFile& f) {
              for (int c = 0; c < kParityClassCount; ++c) f.metadata["class_count." + std::to_string(c)] = "0";
            }),
            WeightsStatus::value_out_of_range);
}

TEST(GeneratorWeights, RefuseDeviationsThatCannotDivide) {
  // the projection divides by them: 1e-40 is a denormal, its reciprocal infinite
  for (const float deviation : {0.0f, -1.0f, 1e-40f}) {
    EXPECT_EQ(statusAfter([&](WeightsFile& f) { f.tensors["basis.deviation"].values[3] = deviation; }),
              WeightsStatus::value_out_of_range)
        << deviation;
  }
}

}  // namespace
}  // namespace nlg
