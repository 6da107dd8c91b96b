// Principal components of sets that are small, nearly uniform, lopsided or ill-scaled, against closed forms and a reference in double.

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "validate/stability/basis_measures.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

// The function that is `value` of the point in the octant, the same in all mirror images.
std::vector<uint8_t> symmetricFunction(const std::function<int(int)>& value) {
  std::vector<uint8_t> phi(kSupportPointCount);
  for (int p = 0; p < kSupportPointCount; ++p) phi[p] = static_cast<uint8_t>(value(p % kOctantPointCount));
  return phi;
}

StabilityResult measureOutlier(const StabilityInputs&) {
  constexpr int kFunctions = 63;
  // faint noise of one step, and one function that is white wherever noise could be
  Random random(17);
  std::vector<uint8_t> phi;
  for (int i = 0; i < kFunctions * kSupportPointCount; ++i) phi.push_back(random.chance(0.01) ? 1 : 0);
  phi.insert(phi.end(), kSupportPointCount, 255);
  const Basis basis = fitBasis(phi, 512);
  const double error = orthonormalityError(basis.data), apart = spectrumError(fallingSpectrum(basis), referenceSpectrum(phi));
  const std::vector<double> spectrum = fallingSpectrum(basis);
  StabilityResult result;
  result.holds = error < kOrthonormal && apart < kSpectrumBound && basis.data.coefficientCount() > kFunctions;
  result.measured = fmt::format(
      "63 functions of one step of noise and one of 255 everywhere: {} components, off orthonormal by {:.1e}; first eigenvalue "
      "{:.1e} times the second; spectrum within {:.1e} of the reference",
      basis.data.coefficientCount(), error, spectrum[0] / spectrum[1], apart);
  result.figures = {{"orthonormality_error", error}, {"spectrum_error", apart}, {"first_over_second", spectrum[0] / spectrum[1]}};
  result.note =
      "Samples are bytes, so that an outlier of 1e6 cannot enter a training set; 255 among samples of 0 and 1 is the largest "
      "that can. Float samples of any size at bake time are the generator's cases.";
  return result;
}

StabilityResult measureIdentical(const StabilityInputs& inputs) {
  const int64_t count = inputs.depth == StabilityDepth::lengthy ? 1000000 : inputs.depth == StabilityDepth::full ? 20000 : 4096;
  const std::vector<uint8_t> same = symmetricFunction([](int i) { return (37 * i) % 256; });
  const auto otherAt = [](int i) { return (37 * i) % 256 ^ (i % 16 == 3 ? 64 : 0); };
  const std::vector<uint8_t> other = symmetricFunction(otherAt);
  std::vector<uint8_t> block;
  for (int n = 0; n < 512; ++n) block.insert(block.end(), same.begin(), same.end());
  BasisFit fit;
  for (int64_t done = 0; done < count; done += 512)
    fit.add(block.data(), static_cast<uint64_t>(std::min<int64_t>(512, count - done)));
  fit.add(other.data(), 1);
  const Basis basis = fit.fit(16);

  // in closed form: one direction, the difference of the two, and the variance of one in count + 1
  double square = 0.0, cosine = 0.0;
  for (int i = 0; i < kOctantPointCount; ++i) square += std::pow((otherAt(i) - same[i]) / 255.0, 2) * kMirrorCount;
  const double share = 1.0 / static_cast<double>(count + 1), variance = square * share * (1.0 - share);
  const double found = fallingSpectrum(basis).front();
  if (basis.data.coefficientCount() == 1) {
    for (int i = 0; i < kOctantPointCount; ++i) {
      cosine += basis.data.components[i] * (otherAt(i) - same[i]) / 255.0 * std::sqrt(8.0 / square);
    }
  }
  StabilityResult result;
  result.holds = basis.data.coefficientCount() == 1 && basis.data.class_count[0] == 1 &&
                 std::fabs(found / variance - 1.0) < 1e-6 && std::fabs(std::fabs(cosine) - 1.0) < 1e-6;
  result.measured = fmt::format(
      "{} identical functions and one other: {} components; variance {:.6e}, in closed form {:.6e}; 1 - cosine to the difference "
      "{:.1e}",
      count, basis.data.coefficientCount(), found, variance, 1.0 - std::fabs(cosine));
  result.figures = {{"identical", double(count)},
                    {"components", basis.data.coefficientCount()},
                    {"variance_relative_error", std::fabs(found / variance - 1.0)},
                    {"one_minus_cosine", 1.0 - std::fabs(cosine)}};
  if (count < 1000000) result.note = "With --long a million are taken.";
  return result;
}

StabilityResult measureIllScaled(const StabilityInputs&) {
  // three independent directions of classes 0, 1 and 6: 100 steps at all points, 1 step at all points, 1 step at 8 points
  const int classes[] = {0, 1, 6}, amplitude[] = {100, 1, 1};
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
  const std::vector<double> spectrum = fallingSpectrum(fitBasis(phi, 64));
  const int points[] = {kSupportPointCount, kSupportPointCount, kMirrorCount};
  double worst = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double exact = std::pow(amplitude[k] / 255.0, 2) * points[k];
    worst = std::max(worst, std::fabs(spectrum[k] / exact - 1.0));
  }
  const int components = fitBasis(phi, 64).data.coefficientCount();
  StabilityResult result;
  result.holds = components == 3 && worst < 1e-6 && spectrum[3] < 1e-9 * spectrum[0];
  result.measured = fmt::format(
      "variances from {:.1e} to {:.1e}: {} components, each within {:.1e} of its closed form; the next eigenvalue is {:.1e}",
      spectrum[0], spectrum[2], components, worst, spectrum[3]);
  result.figures = {
      {"largest_over_smallest", spectrum[0] / spectrum[2]}, {"components", components}, {"variance_relative_error", worst}};
  return result;
}

StabilityResult measureSpectrum(const StabilityInputs&) {
  constexpr int kFunctions = 12;
  const std::vector<uint8_t> phi = wallFunctions(kFunctions, 200);
  const Basis basis = fitBasis(phi, 512);
  const double apart = spectrumError(fallingSpectrum(basis), referenceSpectrum(phi));
  StabilityResult result;
  result.holds = apart < kSpectrumBound;
  result.measured =
      fmt::format("{} functions and their mirror images: {} components; all 8192 eigenvalues within {:.1e} of the largest",
                  kFunctions, basis.data.coefficientCount(), apart);
  result.figures = {{"components", basis.data.coefficientCount()}, {"spectrum_error", apart}};
  return result;
}

}  // namespace

std::vector<StabilityCase> pcaCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  return {
      {"pca", "spectrum against a reference in double",
       "every eigenvalue is that of the scalar products of all functions and mirror images in double, to 1e-11 of the largest",
       brief, false, measureSpectrum},
      {"pca", "one outlier",
       "an outlier as large as bytes allow leaves the components orthonormal and the spectrum that of the reference", full, false,
       measureOutlier},
      {"pca", "many identical functions and one other",
       "the one component is the difference of the two and its variance that of the closed form, to 1e-6", brief, false,
       measureIdentical},
      {"pca", "ill-scaled directions",
       "directions whose variances differ ten million times are all found, to 1e-6 of their own variance, and no others", full,
       false, measureIllScaled},
  };
}

}  // namespace nlg
