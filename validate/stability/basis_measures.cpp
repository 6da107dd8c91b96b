#include "validate/stability/basis_measures.h"

#define EIGEN_USE_BLAS
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "validate/stability/extreme_function.h"

namespace nlg {

std::vector<uint8_t> wallFunctions(int count, uint64_t first_seed) {
  std::vector<uint8_t> phi;
  for (int n = 0; n < count; ++n) {
    const SampledFunction wall = functionBesideWall(first_seed + static_cast<uint64_t>(n), 0.1 + 0.05 * (n % 8));
    phi.insert(phi.end(), wall.phi.begin(), wall.phi.end());
  }
  return phi;
}

Basis fitBasis(const std::vector<uint8_t>& phi, int component_count) {
  BasisFit fit;
  fit.add(phi.data(), phi.size() / kSupportPointCount);
  return fit.fit(component_count);
}

double orthonormalityError(const BasisData& basis) {
  double worst = 0.0;
  int first = 0;
  for (const int count : basis.class_count) {
    const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> rows(
        basis.components.data() + size_t(first) * kOctantPointCount, count, kOctantPointCount);
    const Eigen::MatrixXd exact = rows.cast<double>();
    if (count > 0)
      worst = std::max(worst, (exact * exact.transpose() - Eigen::MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff());
    first += count;
  }
  return worst;
}

std::vector<double> referenceSpectrum(const std::vector<uint8_t>& phi) {
  const int functions = static_cast<int>(phi.size() / kSupportPointCount), images = functions * kMirrorCount;
  Eigen::MatrixXd rows(images, kSupportPointCount);
  for (int n = 0; n < functions; ++n) {
    for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
      for (int p = 0; p < kSupportPointCount; ++p) {
        rows(n * kMirrorCount + mirror, p) = phi[size_t(n) * kSupportPointCount + (p ^ (mirror * kOctantPointCount))] / 255.0;
      }
    }
  }
  rows.rowwise() -= rows.colwise().mean().eval();
  const Eigen::MatrixXd products = rows * rows.transpose() / images;
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(products, Eigen::EigenvaluesOnly).eigenvalues();
  std::vector<double> falling(values.data(), values.data() + values.size());
  std::sort(falling.rbegin(), falling.rend());
  return falling;
}

std::vector<double> fallingSpectrum(const Basis& basis) {
  std::vector<double> spectrum = basis.spectrum;
  std::sort(spectrum.rbegin(), spectrum.rend());
  return spectrum;
}

double spectrumError(const std::vector<double>& spectrum, const std::vector<double>& reference) {
  double worst = 0.0;
  for (size_t i = 0; i < spectrum.size(); ++i) {
    worst = std::max(worst, std::fabs(spectrum[i] - (i < reference.size() ? reference[i] : 0.0)));
  }
  return worst / reference.front();
}

}  // namespace nlg
