#include "train/generator/network/generator_network.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/code_network.h"
#include "tests/train/sample_set.h"
#include "train/generator/network/theta_stages.h"

namespace nlg {
namespace {

const BasisData& networkBasis() {
  static const BasisData data = sampleBasis(kSampleClasses, 2);
  return data;
}

GeneratorShape shapeOf(int width, int layers) {
  GeneratorShape shape;
  shape.coefficient_count = networkBasis().coefficientCount();
  shape.width = width;
  shape.layer_count = layers;
  return shape;
}

// Every number at random, the last layer too.
void shake(GeneratorNetwork& network) {
  torch::NoGradGuard guard;
  torch::manual_seed(3);
  for (torch::Tensor& parameter : network->parameters()) parameter.normal_(0.0, 0.15);
}

TEST(GeneratorNetwork, YieldsTheta0BeforeTraining) {
  const Theta theta0 = randomTheta({}, 1);
  for (const int layers : {1, 2, 6}) {
    GeneratorNetwork network(shapeOf(32, layers), theta0, 7);
    const torch::Tensor theta = network->forward(torch::randn({5, networkBasis().coefficientCount()}));
    ASSERT_EQ(theta.sizes(), torch::IntArrayRef({5, ThetaLayout::count}));
    for (int64_t i = 0; i < theta.numel(); ++i) {
      ASSERT_EQ(theta.data_ptr<float>()[i], theta0[i % ThetaLayout::count]) << layers << " layers, entry " << i;
    }
  }
}

TEST(GeneratorNetwork, AgreesWithTheEvaluatorOnSamples) {
  BasisData trained{.input = GeneratorInput::samples, .deviation = std::vector<float>(24, 1.0f)};
  trained.class_count.fill(3);
  const TrainingData data(sampleSet(40, 50), networkBasis(), trained);
  GeneratorShape shape = shapeOf(32, 3);
  shape.input = GeneratorInput::samples;
  shape.coefficient_count = trained.coefficientCount();
  GeneratorNetwork network(shape, randomTheta({}, 4), 8);
  shake(network);
  const GeneratorData numbers = network->toData(Representation::tentMlp(0.01f), trained);
  const Generator generator(numbers);
  ASSERT_TRUE(generator.readsSamples());
  std::vector<Sample> samples;
  std::vector<StoredFunction> functions;
  for (int64_t n = 0; n < data.functionCount(); ++n) samples.push_back({n}), functions.push_back(data.function(n));
  torch::NoGradGuard guard;
  const torch::Tensor expected = network->forward(inputBatch(data, samples)).contiguous();
  GeneratorScratch scratch(generator);
  std::vector<float> theta(samples.size() * ThetaLayout::count);
  generator.generate(functions.data(), static_cast<int>(samples.size()), theta.data(), &scratch);
  for (size_t i = 0; i < theta.size(); ++i) ASSERT_NEAR(theta[i], expected.data_ptr<float>()[i], 1e-4) << i;
  // components travel with a generator that goes on being trained
  GeneratorNetwork again(nlg::shapeOf(numbers, {}), Theta(ThetaLayout::count), 99);
  again->takeNumbers(numbers);
  EXPECT_EQ(again->toData(numbers.representation, trained).basis.components, numbers.basis.components);
}

TEST(GeneratorNetwork, AgreesWithTheEvaluator) {
  const TrainingData data(sampleSet(40, 50), networkBasis(), networkBasis());
  for (const int width : {17, 25, 64}) {  // 25 coefficients: the first layer has a skip then
    for (const int layers : {1, 2, 4}) {
      GeneratorNetwork network(shapeOf(width, layers), randomTheta({}, 4), 8);
      shake(network);
      const Generator generator(network->toData(Representation::tentMlp(0.01f), networkBasis()));
      EXPECT_TRUE(generator.representation().tentFactor());
      GeneratorScratch scratch(generator);
      std::vector<Sample> samples;
      for (int64_t n = 0; n < data.functionCount(); ++n) samples.push_back({n});
      torch::NoGradGuard guard;
      const torch::Tensor expected = network->forward(inputBatch(data, samples)).contiguous();
      std::vector<float> theta(samples.size() * ThetaLayout::count);
      std::vector<StoredFunction> functions;
      for (int64_t n = 0; n < data.functionCount(); ++n) functions.push_back(data.function(n));
      generator.generate(functions.data(), static_cast<int>(samples.size()), theta.data(), &scratch);
      for (size_t i = 0; i < theta.size(); ++i) {
        // the tolerance of the export's own check
        ASSERT_NEAR(theta[i], expected.data_ptr<float>()[i], 1e-4)
            << "width " << width << ", layers " << layers << ", entry " << i;
      }
    }
  }
}

// As a file holds them: of another output scale, rounded where a dictionary is.
TEST(GeneratorNetwork, TakesTheNumbersOfAGenerator) {
  for (const bool is_code : {false, true}) {
    GeneratorNetwork first = is_code ? codeNetwork(5, 4) : GeneratorNetwork(shapeOf(32, 3), randomTheta({}, 4), 8);
    if (!is_code) shake(first);
    Representation representation = Representation::tentMlp(0.01f);
    if (is_code) {
      representation.kind = RepresentationKind::code;
      representation.code_count = kCodeCount;
    }
    GeneratorData data = first->toData(representation, networkBasis());
    std::fill(data.output_scale.begin(), data.output_scale.end(), 0.4f);
    const GeneratorShape shape = nlg::shapeOf(data, {});
    EXPECT_EQ(shape.width, 32);
    EXPECT_EQ(shape.layer_count, 3);
    EXPECT_EQ(shape.code_count, is_code ? kCodeCount : 0);
    GeneratorNetwork second(shape, Theta(data.theta0.size()), 99);
    second->takeNumbers(data);
    const GeneratorData again = second->toData(data.representation, networkBasis());
    EXPECT_EQ(again.theta0, data.theta0);
    if (is_code) {
      EXPECT_EQ(again.representation.dictionary->data(), data.representation.dictionary->data());
    }
    for (size_t l = 0; l < data.layers.size(); ++l) {
      // the last layer holds what the output scale was
      const float scale = l + 1 == data.layers.size() ? data.output_scale[0] / again.output_scale[0] : 1.0f;
      for (size_t i = 0; i < data.layers[l].weight.size(); ++i)
        ASSERT_NEAR(again.layers[l].weight[i], scale * data.layers[l].weight[i], 1e-6f * std::fabs(again.layers[l].weight[i]));
      for (size_t i = 0; i < data.layers[l].bias.size(); ++i)
        ASSERT_NEAR(again.layers[l].bias[i], scale * data.layers[l].bias[i], 1e-6f * std::fabs(again.layers[l].bias[i]));
    }
  }
}

}  // namespace
}  // namespace nlg
