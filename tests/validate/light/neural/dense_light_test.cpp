#include "validate/light/neural/dense_training.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

TEST(DenseTraining, GradientIsThatOfFiniteDifferences) {
  const DenseShape shape{{6, 9, 8, 3}};
  const torch::Tensor parameters = initialParameters(shape, 5).detach().to(torch::kDouble).requires_grad_();
  torch::Tensor input = torch::empty({7, 6}, torch::kDouble);
  Random random(2);
  for (int i = 0; i < 42; ++i) input.data_ptr<double>()[i] = random.uniform(-1.0, 1.0);
  const auto value = [&](const torch::Tensor& at) { return evaluateBatch(shape, at, input).square().sum(); };
  value(parameters).backward();
  const torch::NoGradGuard no_gradients;
  for (int64_t i = 0; i < parameters.numel(); i += 3) {
    torch::Tensor high = parameters.detach().clone(), low = parameters.detach().clone();
    constexpr double kStep = 1e-6;
    high.data_ptr<double>()[i] += kStep;
    low.data_ptr<double>()[i] -= kStep;
    const double slope = parameters.grad().data_ptr<double>()[i];
    // doubles: 1e-16 of a sum of about 10 over the step
    EXPECT_NEAR(slope, (value(high) - value(low)).item<double>() / (2.0 * kStep), 1e-6 * (1.0 + std::fabs(slope)))
        << "number " << i;
  }
}

}  // namespace
}  // namespace nlg
