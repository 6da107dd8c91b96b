// What the cases of principal components are measured on and with.
#pragma once

#include <cstdint>
#include <vector>

#include "train/basis/basis_fit.h"

namespace nlg {

// Stored samples of functions beside endless walls, N x P.
std::vector<uint8_t> wallFunctions(int count, uint64_t first_seed);

Basis fitBasis(const std::vector<uint8_t>& phi, int component_count);

// Largest |R R^T - I| within the classes of a basis.
double orthonormalityError(const BasisData& basis);

std::vector<double> fallingSpectrum(const Basis& basis);

// Eigenvalues of the covariance of functions and all their mirror images, falling, from the matrix of their scalar products in
// double: no parity classes, no projection, nothing shared with the basis fit.
std::vector<double> referenceSpectrum(const std::vector<uint8_t>& phi);

// Largest difference of two falling spectra, as a share of the first eigenvalue; what one of them lacks counts as 0.
double spectrumError(const std::vector<double>& spectrum, const std::vector<double>& reference);

// Components in float: 1024 products of up to 1, each rounded once.
constexpr double kOrthonormal = 1e-6;
// Sums of 8192 products in double, the eigenvalue solver's error a small multiple of a rounding of the largest.
constexpr double kSpectrumBound = 1e-11;
}  // namespace nlg
