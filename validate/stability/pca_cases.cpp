// Principal components of sets that are nearly uniform, lopsided or ill-scaled, against closed forms.

#include <algorithm>
#include <cmath>

#include "train/basis/basis_fit.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

std::vector<double> falling(std::vector<double> spectrum) {
  std::sort(spectrum.rbegin(), spectrum.rend());
  return spectrum;
}

// Stored samples by the index of a point in the octant: a function that all of its mirror images equal.
using SymmetricFunction = int (*)(int);

// Many times the one function, once the other. In closed form there is one direction, the difference of the two, and its variance is
// that of one in count + 1.
void measureOddOneOut(int64_t count, SymmetricFunction same, SymmetricFunction other, StabilityFigures* figures) {
  std::vector<uint8_t> block, odd_one;
  for (int i = 0; i < 512 * kSupportPointCount; ++i) block.push_back(static_cast<uint8_t>(same(i % kOctantPointCount)));
  for (int p = 0; p < kSupportPointCount; ++p) odd_one.push_back(static_cast<uint8_t>(other(p % kOctantPointCount)));
  BasisFit fit;
  for (int64_t done = 0; done < count; done += 512)
    fit.add(block.data(), static_cast<uint64_t>(std::min<int64_t>(512, count - done)));
  fit.add(odd_one.data(), 1);
  const Basis basis = fit.fit(16);

  double square = 0.0, product = 0.0;
  for (int i = 0; i < kOctantPointCount; ++i) {
    const double difference = (other(i) - same(i)) / 255.0 * std::sqrt(8.0);
    square += difference * difference;
    product += basis.data.components[i] * difference;
  }
  const double share = 1.0 / static_cast<double>(count + 1), variance = square * share * (1.0 - share);
  figures->show("identical_functions", static_cast<double>(count));
  figures->equals("components", basis.data.coefficientCount(), 1);
  figures->equals("components_of_even_functions", basis.data.class_count[0], 1);
  figures->atMost("variance_relative_error", std::fabs(falling(basis.spectrum).front() / variance - 1.0), 1e-6);
  figures->atMost("one_minus_cosine_to_the_difference", std::fabs(1.0 - std::fabs(product) / std::sqrt(square)), 1e-6);
}

int ramp(int i) { return 37 * i % 256; }
int rampWithOtherPoints(int i) { return ramp(i) ^ (i % 16 == 3 ? 64 : 0); }

void measureIdentical(const StabilityInputs& inputs, StabilityFigures* figures) {
  const int64_t count = inputs.depth == StabilityDepth::lengthy ? 1000000 : inputs.isBrief() ? 4096 : 20000;
  measureOddOneOut(count, ramp, rampWithOtherPoints, figures);
  if (inputs.depth != StabilityDepth::lengthy) figures->note = "With --long a million are taken.";
}

void measureOutlier(const StabilityInputs&, StabilityFigures* figures) {
  measureOddOneOut(
      63, [](int i) { return i % 2; }, [](int) { return 255; }, figures);
  figures->note =
      "Samples are bytes, so that an outlier of 1e6 cannot enter a training set; 255 among samples of 0 and 1 is the largest "
      "that can. Float samples of any size at bake time are the generator's cases.";
}

void measureIllScaled(const StabilityInputs&, StabilityFigures* figures) {
  // three independent directions of classes 0, 1 and 6: 100 steps at all points, 1 step at all points, 1 step at 8 points
  const int classes[] = {0, 1, 6}, amplitude[] = {100, 1, 1}, points[] = {kSupportPointCount, kSupportPointCount, kMirrorCount};
  std::vector<uint8_t> phi;
  for (int combination = 0; combination < 8; ++combination) {
    for (int p = 0; p < kSupportPointCount; ++p) {
      int value = 128;
      for (int k = 0; k < 3; ++k) {
        if (k == 2 && p % kOctantPointCount != 77) continue;
        value += amplitude[k] * (combination >> k & 1 ? -1 : 1) * static_cast<int>(mirrorSign(classes[k], p / kOctantPointCount));
      }
      phi.push_back(static_cast<uint8_t>(value));
    }
  }
  BasisFit fit;
  fit.add(phi.data(), 8);
  const Basis basis = fit.fit(64);
  const std::vector<double> spectrum = falling(basis.spectrum);
  double worst = 0.0;
  for (int k = 0; k < 3; ++k)
    worst = std::max(worst, std::fabs(spectrum[k] / (std::pow(amplitude[k] / 255.0, 2) * points[k]) - 1.0));
  figures->show("largest_variance_over_smallest", spectrum[0] / spectrum[2]);
  figures->equals("components", basis.data.coefficientCount(), 3);
  figures->atMost("variance_relative_error", worst, 1e-6);
  figures->atMost("next_eigenvalue_over_first", spectrum[3] / spectrum[0], 1e-9);
}

}  // namespace

std::vector<StabilityCase> pcaCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  const std::string closed_form =
      "the one component is the difference of the two and its variance that of the closed form, to 1e-6";
  return {
      {"pca", "many identical functions and one other", closed_form, brief, false, measureIdentical},
      {"pca", "one outlier, as large as bytes allow", closed_form, full, false, measureOutlier},
      {"pca", "ill-scaled directions",
       "directions whose variances differ ten million times are all found, to 1e-6 of their own variance, and no others", full,
       false, measureIllScaled},
  };
}

}  // namespace nlg
