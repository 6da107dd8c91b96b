#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <type_traits>

#include "nlg/look_up.h"
#include "nlg/nlg.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tests/runtime_eval/c_api/c_engine.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
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

// Solves the last layer, which changes theta of any function.
const GeneratorData& exactData() {
  static const GeneratorData data = [] {
    GeneratorData exact = sampleData();
    exact.exact_last_layer = true;
    return exact;
  }();
  return data;
}

// Functions one after another as an engine holds them, a third of them noise.
struct EngineFunctions {
  std::vector<uint8_t> phi, validity, blend_sum;
  explicit EngineFunctions(int count) {
    for (int n = 0; n < count; ++n) {
      const StoredSample sample = n % 3 == 2 ? noiseSample(n) : crowdedSample(n);
      phi.insert(phi.end(), sample.phi.begin(), sample.phi.end());
      validity.insert(validity.end(), sample.validity.begin(), sample.validity.end());
      blend_sum.insert(blend_sum.end(), sample.blend_sum.begin(), sample.blend_sum.end());
      blend_sum.resize(phi.size(), 255);
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
  explicit Loaded(const GeneratorData& data, const nlg_policy_options* options = nullptr) {
    const std::string bytes = serializeWeights(weightsFromGenerator(data));
    EXPECT_EQ(nlg_generator_load_bytes(bytes.data(), bytes.size(), &generator, nullptr, 0), NLG_OK);
    EXPECT_EQ(nlg_scratch_create(generator, options, &scratch), NLG_OK);
  }
  ~Loaded() {
    nlg_scratch_free(scratch);
    nlg_generator_free(generator);
  }
};

TEST(CApi, GivesAnEngineInCTheNumbersOfTheLibrary) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_c_api_" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary) << serializeWeights(weightsFromGenerator(exactData()));
  constexpr int kCount = 3;
  const EngineFunctions functions(kCount);
  float *theta = nullptr, *values = nullptr;
  const int failed_step = engine_bake(path.c_str(), functions.phi.data(), functions.validity.data(), functions.blend_sum.data(),
                                      kCount, &theta, &values);
  std::filesystem::remove(path);
  ASSERT_EQ(failed_step, 0);

  const Generator generator(exactData());
  const size_t theta_count = ThetaLayout::count;
  std::vector<MadeTheta> made(kCount);
  ThetaPolicy({&generator}, {}).bake(functions.views().data(), kCount, made.data());
  std::vector<float> expected;
  for (const MadeTheta& one : made) {
    ASSERT_FALSE(one.isBareTent());
    expected.insert(expected.end(), one.theta.begin(), one.theta.end());
  }
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

TEST(CApi, RefusesWithAStatusAndAReason) {
  nlg_generator* generator = nullptr;
  char detail[256];
  const auto statusOf = [&](const std::string& bytes) {
    generator = reinterpret_cast<nlg_generator*>(&detail);
    return nlg_generator_load_bytes(bytes.data(), bytes.size(), &generator, detail, sizeof detail);
  };
  EXPECT_EQ(statusOf(sampleBytes().substr(0, 5)), NLG_TOO_SHORT);
  EXPECT_EQ(generator, nullptr);
  EXPECT_STREQ(detail, "shorter than the 8 bytes of the header's length");
  EXPECT_EQ(statusOf(sampleBytes() + "x"), NLG_TENSOR_MALFORMED);
  std::string flipped = sampleBytes();
  flipped[flipped.size() / 2] ^= 4;
  EXPECT_EQ(statusOf(flipped), NLG_DIGEST_MISMATCH);
  EXPECT_EQ(statusOf(serializeWeights({})), NLG_TENSOR_MISSING);
  EXPECT_EQ(nlg_generator_load("/no/such/file", &generator, detail, sizeof detail), NLG_CANNOT_OPEN);
  EXPECT_EQ(std::string(detail).find("/no/such/file: "), 0u) << detail;
  EXPECT_EQ(statusOf(sampleBytes()), NLG_OK);
  EXPECT_STREQ(detail, "");
  nlg_generator_free(generator);
}

// Any other number would be taken for what it is not: a negative count of steps for one that never ends.
TEST(CApi, RefusesEveryOptionOutOfItsRangeByItsName) {
  const Loaded loaded(sampleData());
  const auto refuses = [&]<class Number>(const char* name, Number nlg_policy_options::*option, Number low, Number high) {
    constexpr Number kMost = std::numeric_limits<Number>::max(), kLeast = std::numeric_limits<Number>::lowest();
    std::vector<Number> bad = {kMost, kLeast};
    if constexpr (std::is_same_v<Number, int>) {
      bad.insert(bad.end(), {low - 1, high + 1, -100000});
    } else {
      bad.insert(bad.end(), {std::nextafter(low, kLeast), std::nextafter(high, kMost), std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()});
    }
    nlg_policy_options options = nlg_default_policy();
    for (const Number value : bad) {
      options.*option = value;
      nlg_scratch* scratch = loaded.scratch;
      EXPECT_STREQ(nlg_policy_out_of_range(&options), name) << value;
      EXPECT_EQ(nlg_scratch_create(loaded.generator, &options, &scratch), NLG_VALUE_OUT_OF_RANGE) << name << ' ' << value;
      EXPECT_EQ(scratch, nullptr) << name;
    }
    for (const Number value : {low, high}) {
      options.*option = value;
      EXPECT_EQ(nlg_policy_out_of_range(&options), nullptr) << name << ' ' << value;
    }
  };
#define NLG_CHOICE_OPTION(type, name, value, low, high, help)
#define NLG_POLICY_OPTION(type, name, value, low, high, help) \
  refuses(#name, &nlg_policy_options::name, static_cast<type>(low), static_cast<type>(high));
#include "nlg/policy_options.def"
  nlg_policy_options other = nlg_default_policy();
  EXPECT_EQ(other.theta_precision, NLG_THETA_INT8);
  other.theta_precision = static_cast<nlg_theta_precision>(3);
  EXPECT_STREQ(nlg_policy_out_of_range(&other), "theta_precision");
  EXPECT_EQ(nlg_policy_out_of_range(nullptr), nullptr) << "the defaults";
}

TEST(CApi, AnswersArgumentsThatAreNoneWithAStatus) {
  const Loaded loaded(sampleData()), other(fieldData());
  nlg_generator* generator = loaded.generator;
  nlg_light_grid* grid = nullptr;
  nlg_scratch* scratch = nullptr;
  const float* points = nullptr;
  uint64_t hash = 0;
  char detail[80];
  const void* bytes = sampleBytes().data();
  const size_t size = sampleBytes().size();
  EXPECT_EQ(nlg_generator_load(nullptr, &generator, detail, sizeof detail), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(generator, nullptr);
  EXPECT_NE(std::strstr(detail, "path"), nullptr) << detail;
  EXPECT_EQ(nlg_generator_load("x", nullptr, detail, sizeof detail), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_generator_load_bytes(nullptr, 1, &generator, nullptr, 80), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_generator_load_bytes(nullptr, 0, &generator, nullptr, 0), NLG_TOO_SHORT);
  EXPECT_EQ(nlg_light_grid_load(nullptr, &grid, detail, sizeof detail), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_light_grid_load_bytes(nullptr, 5, &grid, detail, sizeof detail), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_light_grid_load_bytes(bytes, size, nullptr, detail, sizeof detail), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_support_pattern(nullptr, &hash), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_support_pattern(&points, nullptr), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_scratch_create(nullptr, nullptr, &scratch), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_scratch_create(loaded.generator, nullptr, nullptr), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_look_up_scratch_create(nullptr), NLG_INVALID_ARGUMENT);
  const EngineFunctions functions(1);
  const uint8_t *phi = functions.phi.data(), *validity = functions.validity.data();
  std::vector<float> theta(1000);
  EXPECT_EQ(nlg_make_theta(nullptr, phi, validity, nullptr, 1, theta.data(), nullptr, loaded.scratch), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_make_theta(loaded.generator, nullptr, validity, nullptr, 1, theta.data(), nullptr, loaded.scratch),
            NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_make_theta(loaded.generator, phi, nullptr, nullptr, 1, theta.data(), nullptr, loaded.scratch),
            NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_make_theta(loaded.generator, phi, validity, nullptr, 1, nullptr, nullptr, loaded.scratch), NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_make_theta(loaded.generator, phi, validity, nullptr, 1, theta.data(), nullptr, nullptr), NLG_INVALID_ARGUMENT);
  // its theta are longer: written where the caller has room for others
  EXPECT_EQ(nlg_make_theta(loaded.generator, phi, validity, nullptr, 1, theta.data(), nullptr, other.scratch),
            NLG_INVALID_ARGUMENT);
  EXPECT_EQ(nlg_make_theta(loaded.generator, nullptr, nullptr, nullptr, 0, nullptr, nullptr, loaded.scratch), NLG_OK);
  nlg_light_grid_free(nullptr);
  nlg_look_up_scratch_free(nullptr);
  nlg_generator_free(nullptr);
  nlg_scratch_free(nullptr);
}

// Every option has a value of its own, so that two of them taken for one another would show.
TEST(CApi, MakesThetaOfAnyNumberOfFunctionsAsTheLibraryDoes) {
  constexpr size_t kCount = 2 * kBatchCount + 5;
  EngineFunctions functions(kCount);
  // every tenth is the bare tent
  for (size_t n = 0; n < kCount; n += 10) {
    std::fill_n(&functions.validity[n * kValidityByteCount], kValidityByteCount, uint8_t{255});
    std::fill_n(&functions.blend_sum[n * kSupportPointCount], kSupportPointCount, uint8_t{255});
    for (int p = 0; p < kSupportPointCount; ++p) {
      functions.phi[n * kSupportPointCount + p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
    }
  }
  const auto set = [](auto& o) {
    o.bare_tent_rmse = 0.0021, o.good_rmse = 0.0011, o.retry_rmse = 0.0051;
    o.lm_iterations = 4, o.lm_theta0_iterations = 5;
    o.adam_rmse = 0.0031, o.adam_steps = 60;
    o.tau_rmse = 0.021, o.tau_blend = 0.031, o.tau_leak = 0.11, o.dark_weight = 9.0, o.blend_floor = 0.3;
    o.refine_rounds = 1, o.refine_first_steps = 70, o.refine_growth = 8;
  };
  nlg_policy_options options = nlg_default_policy();
  PolicyOptions same;
  set(options), set(same);
  options.theta_precision = NLG_THETA_FLOAT16, same.theta_precision = ThetaPrecision::float16;
  for (const GeneratorData* data : {&exactData(), &fieldData()}) {
    const Loaded loaded(*data, &options);
    const Generator generator(*data);
    ThetaPolicy policy({&generator}, same);
    std::vector<MadeTheta> expected(kCount);
    policy.bake(functions.views().data(), static_cast<int>(kCount), expected.data());
    const size_t theta_count = data->theta0.size();
    for (const size_t count : {size_t{0}, size_t{1}, size_t{kBatchCount}, kCount}) {
      std::vector<float> theta(count * theta_count + 1, -7.0f);
      std::vector<nlg_made> made(count + 1);
      ASSERT_EQ(nlg_make_theta(loaded.generator, functions.phi.data(), functions.validity.data(), functions.blend_sum.data(),
                               count, theta.data(), made.data(), loaded.scratch),
                NLG_OK);
      EXPECT_EQ(theta.back(), -7.0f) << count;
      for (size_t n = 0; n < count; ++n) {
        const MadeTheta& one = expected[n];
        const Theta of_c(&theta[n * theta_count], &theta[n * theta_count] + theta_count);
        EXPECT_EQ(of_c, one.isBareTent() ? Theta(theta_count, 0.0f) : one.theta) << n;
        EXPECT_EQ(made[n].has_theta, !one.isBareTent()) << n;
        EXPECT_EQ(made[n].has_theta, n % 10 != 0) << n;
        EXPECT_EQ(made[n].took_fit, one.record.took_fit) << n;
        EXPECT_STREQ(made[n].ended, stageName(one.record.ended)) << n;
        EXPECT_EQ(made[n].network.rmse, one.record.at(ThetaWord::network).rmse) << n;
        EXPECT_EQ(made[n].corrected.leak_share, one.record.at(ThetaWord::corrected).leak_share) << n;
        EXPECT_EQ(made[n].fitted.rmse, one.record.at(ThetaWord::fitted).rmse) << n;
        EXPECT_EQ(made[n].stored.rmse, one.check().rmse) << n;
        EXPECT_EQ(made[n].stored.passes, one.check().passes(same.check())) << n;
        if (made[n].has_theta == 0) continue;
        const nlg_check check =
            nlg_check_theta(loaded.generator, &functions.phi[n * kSupportPointCount], &functions.validity[n * kValidityByteCount],
                            &functions.blend_sum[n * kSupportPointCount], of_c.data(), loaded.scratch);
        EXPECT_EQ(check.rmse, made[n].stored.rmse) << n;
        EXPECT_EQ(check.blend_rmse, made[n].stored.blend_rmse) << n;
        EXPECT_EQ(check.leak_mean, made[n].stored.leak_mean) << n;
      }
    }
  }
}

// A small grid with light, as a file holds it.
const std::string& gridBytes() {
  static const std::string bytes = [] {
    const LightGrid grid = litGrid(smallTree(), 1);
    std::string text;
    EXPECT_TRUE(serializeLightGrid(grid, {}, {}, &text).ok());
    return text;
  }();
  return bytes;
}

TEST(CApi, GivesAnEngineInCTheLightOfTheLibrary) {
  LightGrid grid;
  GridMetadata texts;
  ASSERT_TRUE(parseLightGrid(gridBytes(), &grid, &texts).ok());
  constexpr size_t kCount = 500;
  Random random(5);
  std::vector<double> positions;
  std::vector<float> normals, rgb(3 * kCount), batched(3 * kCount), expected(3 * kCount), expected_batched(3 * kCount);
  std::vector<unsigned char> status(kCount);
  std::vector<PositionM> positions_m;
  for (size_t i = 0; i < kCount; ++i) {
    positions_m.push_back(randomPosition(grid.tree.frame(), random));
    positions.insert(positions.end(), positions_m.back().begin(), positions_m.back().end());
    const float up = i % 2 == 0 ? 1.0f : -1.0f;
    normals.insert(normals.end(), {0.0f, 0.0f, up});
  }
  ASSERT_EQ(engine_light(gridBytes().data(), gridBytes().size(), positions.data(), normals.data(), kCount, rgb.data(),
                         batched.data(), status.data()),
            0);
  std::vector<LightStatus> expected_status(kCount);
  lookUpIrradiances(grid, positions_m.data(), normals.data(), kCount, expected_batched.data(), expected_status.data());
  for (size_t i = 0; i < kCount; ++i) {
    lookUpIrradiance(grid, positions_m[i], &normals[3 * i], &expected[3 * i]);
    EXPECT_EQ(status[i], static_cast<unsigned char>(expected_status[i]));
  }
  EXPECT_EQ(rgb, expected);
  EXPECT_EQ(batched, expected_batched);
}

TEST(CApi, SaysWhereAGridIsAndHowBright) {
  LightGrid read;
  GridMetadata texts;
  ASSERT_TRUE(parseLightGrid(gridBytes(), &read, &texts).ok());
  nlg_light_grid* grid = nullptr;
  ASSERT_EQ(nlg_light_grid_load_bytes(gridBytes().data(), gridBytes().size(), &grid, nullptr, 0), NLG_OK);
  double low_m[3], high_m[3];
  float rgb[3];
  nlg_light_grid_bounds(grid, low_m, high_m);
  nlg_light_grid_mean_radiance(grid, rgb);
  // probes stand at the corners of cells in use, and nowhere else
  for (int axis = 0; axis < 3; ++axis) {
    double lowest = INFINITY, highest = -INFINITY, sum = 0.0, count = 0.0;
    for (size_t probe = 0; probe < read.tree.probeCount(); ++probe) {
      lowest = std::min(lowest, read.tree.probePosition(probe)[axis]);
      highest = std::max(highest, read.tree.probePosition(probe)[axis]);
      if (read.probe_function[probe] == kNoWeight) continue;
      sum += read.probeLight(probe)[axis];  // of a colour, here
      ++count;
    }
    EXPECT_NEAR(low_m[axis], lowest, 1e-9);
    EXPECT_NEAR(high_m[axis], highest, 1e-9);
    ASSERT_GT(count, 0.0);
    // of a constant radiance L the first coefficient is L times the root of 4 pi
    EXPECT_NEAR(rgb[axis], sum / count / std::sqrt(4.0 * M_PI), 1e-5 * std::abs(rgb[axis]));
  }
  nlg_light_grid_free(grid);
}

TEST(CApi, RefusesAGridWithAStatusAndAReason) {
  nlg_light_grid* grid = nullptr;
  char detail[200];
  EXPECT_EQ(nlg_light_grid_load("/no/such/grid", &grid, detail, sizeof detail), NLG_CANNOT_OPEN);
  EXPECT_EQ(grid, nullptr);
  EXPECT_NE(std::string(detail).find("/no/such/grid"), std::string::npos) << detail;
  EXPECT_EQ(nlg_light_grid_load_bytes(gridBytes().data(), gridBytes().size() - 1, &grid, detail, sizeof detail), NLG_TOO_SHORT);
  EXPECT_EQ(grid, nullptr);
  EXPECT_EQ(nlg_light_grid_load_bytes(gridBytes().data(), gridBytes().size(), &grid, nullptr, 0), NLG_OK);
  nlg_light_grid_free(grid);
}

}  // namespace
}  // namespace nlg
