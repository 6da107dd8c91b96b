#include "runtime_eval/fit/adam_update.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

constexpr double kBeta1 = 0.8, kBeta2 = 0.99;
constexpr int kTurn = 48;  // the basis is turned for the first time before the step after so many

std::vector<Representation> networks() {
  std::vector<Representation> all;
  for (int i = 0; i < kNetworkCount; ++i) all.push_back({static_cast<RepresentationKind>(i)});
  return all;
}

std::vector<float> normals(size_t count, uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random.normal());
  return values;
}

TEST(SoapMoments, StepAsAdamUntilTheBasisTurns) {
  forEachTarget([] {
    for (const Representation& network : networks()) {
      const int count = network.thetaCount();
      std::vector<float> soap_theta = normals(count, 1), adam_theta = soap_theta;
      SoapMoments soap;
      soap.reset(network);
      AdamMoments adam(count);
      double rates = 0.0;
      for (int step = 0; step < kTurn; ++step) {
        const std::vector<float> gradient = normals(count, 100 + step);
        soap.step(0.01, kBeta1, kBeta2, 0.5f, gradient.data(), soap_theta.data());
        adam.step(0.01, kBeta1, kBeta2, 0.5f, gradient.data(), adam_theta.data());
        rates += 0.01;
      }
      // a step is at most twice its rate, and its root is good to 11 bits at least
      for (int i = 0; i < count; ++i) EXPECT_NEAR(soap_theta[i], adam_theta[i], rates * 2 * 0x1p-11) << network.network().name;
    }
  });
}

// A layer's loss |A (W - W*) B|² / 2, A and B badly conditioned and nowhere near the axes; its gradient is A^T A (W - W*) B B^T.
class TiltedValley {
 public:
  static constexpr int kRows = 8, kColumns = 9;
  TiltedValley() : left_(tilted(kRows, 7)), right_(tilted(kColumns, 8)) {}

  // weights, biases   places of the layer in theta
  double loss(const float* theta, int weights, int biases, float* gradient) const {
    std::array<std::array<double, kColumns>, kRows> off{}, half{}, whole{};
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kColumns; ++c) off[r][c] = theta[place(weights, biases, r, c)] - 0.1 * (r - c);
    }
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kColumns; ++c) {
        for (int i = 0; i < kRows; ++i) half[r][c] += left_[r * kRows + i] * off[i][c];
      }
    }
    double loss = 0.0;
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kColumns; ++c) {
        for (int i = 0; i < kColumns; ++i) whole[r][c] += half[r][i] * right_[i * kColumns + c];
        loss += 0.5 * whole[r][c] * off[r][c];
        gradient[place(weights, biases, r, c)] = static_cast<float>(whole[r][c]);
      }
    }
    return loss;
  }

 private:
  static int place(int weights, int biases, int r, int c) { return c == kColumns - 1 ? biases + r : weights + 8 * r + c; }
  // Symmetric with eigenvalues from 1 to .001, turned by reflections.
  static std::vector<double> tilted(int count, uint64_t seed) {
    std::vector<double> matrix(count * count, 0.0);
    for (int i = 0; i < count; ++i) matrix[i * count + i] = std::pow(10.0, -3.0 * i / (count - 1));
    for (int turn = 0; turn < 3; ++turn) {
      const std::vector<float> normal = normals(count, seed + 10 * turn);
      double square = 0.0;
      for (const float value : normal) square += value * value;
      std::vector<double> reflection(count * count), product(count * count, 0.0), turned(count * count, 0.0);
      for (int i = 0; i < count * count; ++i) {
        reflection[i] = (i / count == i % count) - 2.0 * normal[i / count] * normal[i % count] / square;
      }
      const auto multiply = [count](const std::vector<double>& a, const std::vector<double>& b, std::vector<double>& result) {
        for (int r = 0; r < count; ++r) {
          for (int c = 0; c < count; ++c) {
            for (int i = 0; i < count; ++i) result[r * count + c] += a[r * count + i] * b[i * count + c];
          }
        }
      };
      multiply(reflection, matrix, product);
      multiply(product, reflection, turned);
      matrix = turned;
    }
    return matrix;
  }

  std::vector<double> left_, right_;
};

TEST(SoapMoments, GoDownATiltedValleyWhereAdamStaysBehind) {
  const Representation network = Representation::tentMlp();
  const NetworkShape& shape = network.shape();
  const TiltedValley valley;
  constexpr int kSteps = 600;
  // the loss that is left of that of theta = 0
  const auto left = [&](auto& moments) {
    std::vector<float> theta(network.thetaCount(), 0.0f), gradient(theta.size(), 0.0f);
    const double before = valley.loss(theta.data(), shape.w2(), shape.b2(), gradient.data());
    for (int step = 0; step < kSteps; ++step) {
      const double rate = 0.01 * (1.0 + std::cos(M_PI * step / kSteps));
      moments.step(rate, kBeta1, kBeta2, 1.0f, gradient.data(), theta.data());
      valley.loss(theta.data(), shape.w2(), shape.b2(), gradient.data());
    }
    for (int i = 0; i < shape.w2(); ++i) EXPECT_EQ(theta[i], 0.0f) << "no gradient, no step";
    return valley.loss(theta.data(), shape.w2(), shape.b2(), gradient.data()) / before;
  };
  forEachTarget([&] {
    AdamMoments adam(network.thetaCount());
    SoapMoments soap;
    soap.reset(network);
    const double by_adam = left(adam), by_soap = left(soap);
    EXPECT_LT(by_soap, 0.1 * by_adam) << by_adam;
  });
}

TEST(SoapMoments, KeepStepsBoundedUnderGradientsOfAnySize) {
  forEachTarget([] {
    const Representation network = Representation::mlp();
    const int count = network.thetaCount();
    for (const float size : {0.0f, 1e-18f, 1e-6f, 1e6f}) {
      SoapMoments moments;
      moments.reset(network);
      std::vector<float> theta(count, 0.0f);
      for (int step = 0; step < 3 * kTurn; ++step) {
        std::vector<float> gradient = normals(count, 900 + step);
        for (float& value : gradient) value *= size;
        moments.step(0.01, kBeta1, kBeta2, 1.0f, gradient.data(), theta.data());
      }
      // In the basis a step is at most 2 (adam_update_test) of its rate, of each of a layer's at most 72 numbers: no number of theta
      // moves by more than the root of that.
      for (const float value : theta) EXPECT_LE(std::fabs(value), 0.01 * 3 * kTurn * 2 * std::sqrt(72.0) * 1.01) << size;
    }
  });
}

}  // namespace
}  // namespace nlg
