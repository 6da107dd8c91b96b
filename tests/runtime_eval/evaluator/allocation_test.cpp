// The hot calls allocate nothing.
#include <gtest/gtest.h>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/policy/stage_runner.h"
#include "tests/runtime_eval/counting_new.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

TEST(Generator, AllocatesNothingAfterLoad) {
  constexpr int kCount = 37;
  const SampleFunctions samples = sampleFunctions(kCount);
  const std::vector<StoredFunction> functions = samples.views();
  for (const GeneratorInput input : {GeneratorInput::coefficients, GeneratorInput::samples}) {
    const Representation representation =
        input == GeneratorInput::samples ? Representation::mlp() : Representation::productField(5);
    const Generator generator(sampleGenerator(representation, 48, 3, 1, input));
    GeneratorScratch scratch(generator);
    std::vector<float> theta(size_t(kCount) * representation.thetaCount());
    // the very first calls, as an engine makes them
    const long before = allocationCount();
    generator.generate(functions.data(), kCount, theta.data(), &scratch);
    generator.generate(functions.data(), 1, theta.data(), &scratch);
    EXPECT_EQ(allocationCount(), before) << representationName(representation);
  }
}

TEST(StageRunner, AllocatesNothingOnceMade) {
  constexpr int kCount = 37;
  const std::vector<uint8_t> phi = sampleFunctions(kCount).phi, validity(kValidityByteCount, 255);
  for (const Representation& representation : {Representation::mlp(), Representation::productField(5)}) {
    GeneratorData data = sampleGenerator(representation, 48, 3, 1);
    data.exact_last_layer = !representation.isField();
    const Generator generator(data);
    StageRunner runner(generator, PolicyOptions{});
    std::vector<ThetaRecord> records(kCount);
    std::vector<StoredFunction> functions;
    for (int i = 0; i < kCount; ++i) functions.push_back({&phi[size_t(i) * kSupportPointCount], validity.data()});
    std::vector<float> theta(size_t(kCount) * representation.thetaCount(), 0.1f);
    const long before = allocationCount();
    runner.make(functions.data(), kCount, theta.data(), records.data());
    EXPECT_EQ(allocationCount(), before) << representationName(representation);
  }
}

}  // namespace
}  // namespace nlg
