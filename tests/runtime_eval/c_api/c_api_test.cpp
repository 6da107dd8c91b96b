#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "runtime_eval/c_api/nlg.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/fit/correction.h"
#include "runtime_eval/fit/refinement.h"
#include "tests/runtime_eval/c_api/c_engine.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

const GeneratorData& sampleData() {
  static const GeneratorData data = sampleGenerator(Representation::tentMlp(0.02f), 24, 3, 8);
  return data;
}
// Of another length of theta.
const GeneratorData& fieldData() {
  static const GeneratorData data = sampleGenerator(Representation::productField(5), 24, 3, 9);
  return data;
}
const std::string& sampleBytes() {
  static const std::string bytes = serializeWeights(weightsFromGenerator(sampleData()));
  return bytes;
}

// Solves the last layer, which changes theta of any function, then takes two steps.
const GeneratorData& correctedData() {
  static const GeneratorData data = [] {
    GeneratorData exact = withCorrection(sampleData(), 20, 3, 2, 4);
    exact.correction.exact_last_layer = true;
    return exact;
  }();
  return data;
}

// Functions one after another as an engine holds them, a third of them noise.
struct EngineFunctions {
  std::vector<uint8_t> phi, validity;
  explicit EngineFunctions(int count) {
    for (int n = 0; n < count; ++n) {
      const StoredSample sample = n % 3 == 2 ? noiseSample(n) : wallSample(n);
      phi.insert(phi.end(), sample.phi.begin(), sample.phi.end());
      validity.insert(validity.end(), sample.validity.begin(), sample.validity.end());
    }
  }
  std::vector<StoredFunction> views() const {
    std::vector<StoredFunction> functions;
    for (size_t n = 0; n * kSupportPointCount < phi.size(); ++n) functions.push_back(storedFunction(*this, n));
    return functions;
  }
};

struct Loaded {
  nlg_generator* generator = nullptr;
  nlg_scratch* scratch = nullptr;
  explicit Loaded(const GeneratorData& data) {
    const std::string bytes = serializeWeights(weightsFromGenerator(data));
    EXPECT_EQ(nlg_generator_load_bytes(bytes.data(), bytes.size(), NLG_FLOAT32, &generator, nullptr, 0), NLG_OK);
    EXPECT_EQ(nlg_scratch_create(generator, &scratch), NLG_OK);
  }
  ~Loaded() {
    nlg_scratch_free(scratch);
    nlg_generator_free(generator);
  }
};

TEST(CApi, GivesAnEngineInCTheNumbersOfTheLibrary) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_c_api_" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary) << serializeWeights(weightsFromGenerator(correctedData()));
  constexpr int kCount = 3;
  const EngineFunctions functions(kCount);
  float *theta = nullptr, *values = nullptr;
  const int failed_step = engine_bake(path.c_str(), functions.phi.data(), functions.validity.data(), kCount, &theta, &values);
  std::filesystem::remove(path);
  ASSERT_EQ(failed_step, 0);

  const Generator generator(correctedData());
  GeneratorScratch scratch(generator);
  const size_t theta_count = ThetaLayout::count;
  std::vector<float> expected(kCount * theta_count);
  generator.generate(functions.phi.data(), kCount, expected.data(), &scratch);
  ASSERT_EQ(Corrector(generator).correct(functions.views().data(), kCount, expected.data()), kCount);
  const PointSet points = makePointSet(supportPattern().points);
  AlignedFloats expected_values(points.padded_count);
  for (int n = 0; n < kCount; ++n) {
    EXPECT_EQ(std::memcmp(theta + n * theta_count, &expected[n * theta_count], theta_count * sizeof(float)), 0) << n;
    evaluate(generator.representation(), points, &expected[n * theta_count], expected_values.data());
    EXPECT_EQ(std::memcmp(values + n * kSupportPointCount, expected_values.data(), kSupportPointCount * sizeof(float)), 0) << n;
  }
  std::free(theta);
  std::free(values);
}

TEST(CApi, LoadsInThePrecisionAskedFor) {
  nlg_generator* generator = nullptr;
  nlg_scratch* c_scratch = nullptr;
  ASSERT_EQ(nlg_generator_load_bytes(sampleBytes().data(), sampleBytes().size(), NLG_INT16, &generator, nullptr, 0), NLG_OK);
  ASSERT_EQ(nlg_scratch_create(generator, &c_scratch), NLG_OK);
  const std::vector<uint8_t> phi = sampleFunctions(1);
  std::vector<float> theta(ThetaLayout::count), int16(theta), float32(theta);
  nlg_generate(generator, phi.data(), 1, theta.data(), c_scratch);
  nlg_scratch_free(c_scratch);
  nlg_generator_free(generator);
  for (const GeneratorPrecision precision : {GeneratorPrecision::int16, GeneratorPrecision::float32}) {
    const Generator expected(sampleData(), precision);
    GeneratorScratch scratch(expected);
    expected.generate(phi.data(), 1, (precision == GeneratorPrecision::int16 ? int16 : float32).data(), &scratch);
  }
  EXPECT_EQ(theta, int16);
  EXPECT_NE(theta, float32);
}

TEST(CApi, DescribesWhatItLoaded) {
  const Loaded loaded(sampleData()), field(fieldData());
  EXPECT_STREQ(nlg_representation_name(field.generator), "pf5");
  EXPECT_EQ(nlg_theta_count(field.generator), 250u);
  EXPECT_STREQ(nlg_representation_name(loaded.generator), "tent_mlp");
  EXPECT_EQ(nlg_representation_slope(loaded.generator), 0.02f);
  ASSERT_EQ(nlg_theta_count(loaded.generator), sampleData().theta0.size());
  EXPECT_EQ(std::memcmp(nlg_theta0(loaded.generator), sampleData().theta0.data(), sampleData().theta0.size() * sizeof(float)), 0);
}

TEST(CApi, NamesTheSupportPointsAndTheirHash) {
  const float* points = nullptr;
  uint64_t hash = 0;
  ASSERT_EQ(nlg_support_pattern(&points, &hash), NLG_OK);
  EXPECT_EQ(hash, supportPattern().hash);
  for (int p : {0, 1, 1024, NLG_SUPPORT_POINT_COUNT - 1}) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(points[3 * p + axis], supportPattern().points[p][axis]) << p;
  }
}

TEST(CApi, EvaluatesAnyNumberOfPointsAndWritesNoMore) {
  const std::vector<LocalPoint> points = testPoints(1025);
  std::vector<float> x, y, z;
  for (const LocalPoint& point : points) x.push_back(point[0]), y.push_back(point[1]), z.push_back(point[2]);
  for (const GeneratorData* data : {&sampleData(), &fieldData()}) {
    const Loaded loaded(*data);
    const float* theta = nlg_theta0(loaded.generator);
    for (const size_t count : {0, 1, 15, 16, 17, 511, 512, 513, 1025}) {
      std::vector<float> values(count + 1, -7.0f);
      nlg_evaluate(loaded.generator, theta, count, x.data(), y.data(), z.data(), values.data(), loaded.scratch);
      const PointSet set = makePointSet({points.begin(), points.begin() + static_cast<int>(count)});
      AlignedFloats expected(set.padded_count);
      evaluate(data->representation, set, theta, expected.data());
      EXPECT_TRUE(std::equal(values.begin(), values.end() - 1, expected.begin())) << count;
      EXPECT_EQ(values.back(), -7.0f) << count;
    }
  }
}

TEST(CApi, GeneratesThetaOfAnyLength) {
  const Loaded loaded(fieldData());
  const std::vector<uint8_t> phi = sampleFunctions(5);
  std::vector<float> theta(5 * 250 + 1, -7.0f), expected(5 * 250);
  nlg_generate(loaded.generator, phi.data(), 5, theta.data(), loaded.scratch);
  const Generator generator(fieldData());
  GeneratorScratch scratch(generator);
  generator.generate(phi.data(), 5, expected.data(), &scratch);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), theta.begin()));
  EXPECT_EQ(theta.back(), -7.0f);
}

TEST(CApi, RefusesWithAStatusAndAReason) {
  nlg_generator* generator = nullptr;
  char detail[256];
  const auto statusOf = [&](const std::string& bytes) {
    generator = reinterpret_cast<nlg_generator*>(&detail);
    return nlg_generator_load_bytes(bytes.data(), bytes.size(), NLG_FLOAT32, &generator, detail, sizeof detail);
  };
  EXPECT_EQ(statusOf(sampleBytes().substr(0, 5)), NLG_TOO_SHORT);
  EXPECT_EQ(generator, nullptr);
  EXPECT_STREQ(detail, "no 8 bytes for the header's length");
  EXPECT_EQ(statusOf(sampleBytes() + "x"), NLG_TENSOR_MALFORMED);
  EXPECT_EQ(statusOf(serializeWeights({})), NLG_TENSOR_MISSING);
  EXPECT_EQ(nlg_generator_load("/no/such/file", NLG_FLOAT32, &generator, detail, sizeof detail), NLG_CANNOT_OPEN);
  EXPECT_EQ(std::string(detail).find("/no/such/file: "), 0u) << detail;
  EXPECT_EQ(statusOf(sampleBytes()), NLG_OK);
  EXPECT_STREQ(detail, "");
  nlg_generator_free(generator);
}

TEST(CApi, CutsTheReasonToTheBufferBetweenCharacters) {
  nlg_generator* generator = nullptr;
  const std::string path = "/né";
  char detail[8] = "unsized";
  nlg_generator_load(path.c_str(), NLG_FLOAT32, &generator, nullptr, 0);
  EXPECT_STREQ(detail, "unsized");
  nlg_generator_load(path.c_str(), NLG_FLOAT32, &generator, detail, 1);
  EXPECT_STREQ(detail, "");
  nlg_generator_load(path.c_str(), NLG_FLOAT32, &generator, detail, 4);  // room for three bytes; é has two
  EXPECT_STREQ(detail, "/n");
  nlg_generator_load(path.c_str(), NLG_FLOAT32, &generator, detail, 5);
  EXPECT_STREQ(detail, "/né");
}

TEST(CApi, NamesEveryStatus) {
  for (int status = NLG_OK; status <= NLG_SIMD_UNAVAILABLE; ++status) {
    EXPECT_STRNE(nlg_status_name(static_cast<nlg_status>(status)), "unknown") << status;
  }
  EXPECT_STREQ(nlg_status_name(NLG_TENSOR_MISSING), "tensor_missing");
  EXPECT_STREQ(nlg_status_name(NLG_OUT_OF_MEMORY), "out_of_memory");
  EXPECT_STREQ(nlg_status_name(static_cast<nlg_status>(NLG_SIMD_UNAVAILABLE + 1)), "unknown");
}

TEST(CApi, ChecksAndRefinesAsTheLibraryDoes) {
  const Loaded loaded(sampleData());
  const StoredSample sample = wallSample(3);
  std::vector<float> theta(113);
  nlg_generate(loaded.generator, sample.phi.data(), 1, theta.data(), loaded.scratch);
  nlg_refinement_options options = nlg_default_refinement();
  EXPECT_EQ(options.tau_rmse, RefinementOptions{}.check.tau_rmse);
  EXPECT_EQ(options.growth, RefinementOptions{}.growth);
  options.first_steps = 100;
  RefinementOptions same;
  same.first_steps = 100;
  const Representation& representation = Generator(sampleData()).representation();
  FunctionChecker checker;
  const FunctionCheck expected = checker.check(representation, sample.view(), theta.data(), same.check);
  const nlg_check before =
      nlg_check_theta(loaded.generator, sample.phi.data(), sample.validity.data(), theta.data(), &options, loaded.scratch);
  EXPECT_EQ(before.rmse, expected.rmse);
  EXPECT_EQ(before.leak_mean, expected.leak_mean);
  EXPECT_EQ(before.leak_share, expected.leak_share);
  EXPECT_EQ(before.passes, 0);
  const RefinementResult refined =
      Refiner().refine(representation, sample.view(), theta, {sampleData().theta0.begin(), sampleData().theta0.end()}, same);
  nlg_check after{};
  EXPECT_EQ(
      nlg_refine(loaded.generator, sample.phi.data(), sample.validity.data(), theta.data(), &options, &after, loaded.scratch),
      NLG_OK);
  EXPECT_EQ(theta, refined.theta);
  EXPECT_EQ(after.rmse, refined.check.rmse);
  EXPECT_LT(after.rmse, before.rmse);
}

TEST(CApi, CorrectsAnyNumberOfFunctionsAsTheLibraryDoes) {
  constexpr size_t kCount = 2 * kBatchCount + 5;
  const EngineFunctions functions(kCount);
  const GeneratorData field = withCorrection(fieldData(), 20, 3, 2, 4);
  for (const GeneratorData* data : {&correctedData(), &field}) {
    const Loaded loaded(*data);
    const Generator generator(*data);
    const size_t theta_count = data->theta0.size();
    for (const size_t count : {size_t{0}, size_t{1}, size_t{kBatchCount}, kCount}) {
      std::vector<float> theta(count * theta_count + 1, -7.0f);
      nlg_generate(loaded.generator, functions.phi.data(), count, theta.data(), loaded.scratch);
      std::vector<float> expected = theta;
      const int changed = Corrector(generator).correct(functions.views().data(), static_cast<int>(count), expected.data());
      EXPECT_EQ(
          nlg_correct(loaded.generator, functions.phi.data(), functions.validity.data(), count, theta.data(), loaded.scratch),
          static_cast<size_t>(changed))
          << count;
      EXPECT_EQ(theta, expected) << count;
      EXPECT_EQ(theta.back(), -7.0f) << count;
      // the best last layer is better than one of random numbers
      if (data == &correctedData()) {
        EXPECT_EQ(changed, static_cast<int>(count));
      }
    }
  }
}

TEST(CApi, CorrectsNothingWithoutStepsInTheWeights) {
  const Loaded loaded(sampleData());
  const EngineFunctions functions(2);
  std::vector<float> theta(2 * nlg_theta_count(loaded.generator));
  nlg_generate(loaded.generator, functions.phi.data(), 2, theta.data(), loaded.scratch);
  const std::vector<float> generated = theta;
  EXPECT_EQ(nlg_correct(loaded.generator, functions.phi.data(), functions.validity.data(), 2, theta.data(), loaded.scratch), 0u);
  EXPECT_EQ(theta, generated);
}

TEST(CApi, FreesNothingWhenThereIsNothing) {
  nlg_generator_free(nullptr);
  nlg_scratch_free(nullptr);
}

}  // namespace
}  // namespace nlg
