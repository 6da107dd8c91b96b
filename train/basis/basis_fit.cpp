#include "train/basis/basis_fit.h"

#define EIGEN_USE_BLAS
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tool/error.h"
#include "tool/parallel_for.h"

// LAPACK's own name: eigenvalues by rising size and eigenvectors of a symmetric matrix, which the eigenvectors replace. By divide and
// conquer, at a fifth of the time of Eigen's solver at 1024.
extern "C" void dsyevd_(const char* job, const char* triangle, const int* size, double* matrix, const int* stride, double* values,
                        double* work, const int* work_size, int* integers, const int* integer_count, int* info);

namespace nlg {
namespace {

constexpr int kBlockCount = 512;  // functions at a time
constexpr int kSize = kOctantPointCount;
const double kClassScale = 1.0 / (255.0 * std::sqrt(8.0));

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Runs work(c) for every parity class, on as many threads as the machine has; each class is one thread's, so the result does not
// depend on their number.
template <class Work>
void forEachClass(const Work& work) {
  parallelFor(kParityClassCount, machineThreadCount(), [&](uint64_t c, int) { work(static_cast<int>(c)); });
}

// Class c of transformed functions as rows in double, on the scale of phi in [0, 1].
Matrix classRows(const std::vector<float>& classes, int count, int c) {
  Matrix rows(count, kSize);
  for (int n = 0; n < count; ++n) {
    const float* source = &classes[size_t(n) * kClassStride + size_t(c) * kSize];
    for (int i = 0; i < kSize; ++i) rows(n, i) = kClassScale * source[i];
  }
  return rows;
}

// The eigenvectors of a symmetric matrix of kSize rows, in its place, as columns; the eigenvalues by rising size.
Eigen::VectorXd solveEigen(Eigen::MatrixXd* matrix) {
  Eigen::VectorXd values(kSize);
  // asked for its sizes, then run
  std::vector<double> work(1);
  std::vector<int> integers(1);
  for (const bool is_asked : {true, false}) {
    const int work_size = is_asked ? -1 : static_cast<int>(work.size());
    const int integer_count = is_asked ? -1 : static_cast<int>(integers.size());
    int info = 0;
    dsyevd_("V", "L", &kSize, matrix->data(), &kSize, values.data(), work.data(), &work_size, integers.data(), &integer_count,
            &info);
    if (info != 0) throw NumericalError("basis: the covariance: no eigenvectors found");
    work.resize(static_cast<size_t>(work[0]));
    integers.resize(static_cast<size_t>(integers[0]));
  }
  return values;
}

struct Component {
  double variance;
  int parity_class, rank;
};

}  // namespace

BasisFit::BasisFit() : sum_(kSize, 0.0) {
  for (ClassMatrix& products : products_) products.assign(size_t{kSize} * kSize, 0.0);
}

void BasisFit::add(const uint8_t* phi, uint64_t count) {
  for (uint64_t begin = 0; begin < count; begin += kBlockCount) {
    const int block = static_cast<int>(std::min<uint64_t>(kBlockCount, count - begin));
    std::vector<float> classes(size_t(block) * kClassStride);
    parityTransform(phi + begin * kSupportPointCount, block, classes.data());
    // class 0 alone has a mean: shifted by that of the first block, so that no digits cancel (docs/theory/math.md §3)
    if (shift_.empty()) {
      const Matrix rows = classRows(classes, block, 0);
      const Eigen::RowVectorXd mean = rows.colwise().mean();
      shift_.assign(mean.data(), mean.data() + kSize);
    }
    forEachClass([&](int c) {
      Matrix rows = classRows(classes, block, c);
      if (c == 0) {
        rows.rowwise() -= Eigen::Map<const Eigen::RowVectorXd>(shift_.data(), kSize);
        Eigen::Map<Eigen::RowVectorXd>(sum_.data(), kSize) += rows.colwise().sum();
      }
      Eigen::Map<Matrix> products(products_[c].data(), kSize, kSize);
      products.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    });
    count_ += block;
  }
}

Basis BasisFit::fit(int component_count) const {
  Basis basis;
  basis.function_count = count_;
  if (count_ == 0) throw InputError("training set", "functions", "at least two different ones", "none");
  const double scale = 1.0 / static_cast<double>(count_);
  const Eigen::Map<const Eigen::VectorXd> sum(sum_.data(), kSize);
  std::array<Eigen::MatrixXd, kParityClassCount> vectors;
  basis.spectrum.assign(size_t{kParityClassCount} * kSize, 0.0);
  // between classes the covariance is 0: eight blocks, each by itself (docs/theory/math.md §3)
  forEachClass([&](int c) {
    Eigen::MatrixXd covariance = scale * Eigen::Map<const Matrix>(products_[c].data(), kSize, kSize);
    if (c == 0) covariance -= (scale * sum) * (scale * sum).transpose();
    const Eigen::VectorXd values = solveEigen(&covariance);
    vectors[c] = covariance.rowwise().reverse();
    for (int i = 0; i < kSize; ++i) basis.spectrum[size_t(c) * kSize + i] = std::max(0.0, values[kSize - 1 - i]);
  });

  // the largest of all classes together, without directions that no function spans; then class by class, as files hold them
  std::vector<Component> candidates;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (int i = 0; i < kSize; ++i) candidates.push_back({basis.spectrum[size_t(c) * kSize + i], c, i});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Component& a, const Component& b) { return a.variance > b.variance; });
  const double smallest = 1e-9 * candidates.front().variance;
  if (!(candidates.front().variance > 1e-18)) {
    throw InputError("training set", "functions", "at least two different ones", std::to_string(count_) + " equal ones");
  }
  candidates.resize(std::min<size_t>(candidates.size(), component_count));
  std::erase_if(candidates, [&](const Component& candidate) { return candidate.variance <= smallest; });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Component& a, const Component& b) { return a.parity_class < b.parity_class; });

  // in all classes but the first the mean is 0
  basis.data.mean.assign(size_t{kParityClassCount} * kSize, 0.0f);
  for (int i = 0; i < kSize; ++i) basis.data.mean[i] = static_cast<float>(shift_[i] + scale * sum_[i]);
  for (const Component& component : candidates) {
    ++basis.data.class_count[component.parity_class];
    basis.data.deviation.push_back(static_cast<float>(std::sqrt(component.variance)));
    const auto column = vectors[component.parity_class].col(component.rank);
    // eigenvectors have no sign of their own: the largest entry is made positive
    Eigen::Index largest = 0;
    column.cwiseAbs().maxCoeff(&largest);
    const double sign = column[largest] < 0 ? -1.0 : 1.0;
    for (int i = 0; i < kSize; ++i) basis.data.components.push_back(static_cast<float>(sign * column[i]));
  }
  return basis;
}

namespace {

// Indices of the components by falling variance.
std::vector<int> componentsByVariance(const BasisData& data) {
  std::vector<int> order(data.coefficientCount());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return data.deviation[a] > data.deviation[b]; });
  return order;
}

}  // namespace

Basis truncateBasis(const Basis& basis, int component_count) {
  std::vector<int> kept = componentsByVariance(basis.data);
  kept.resize(std::min<size_t>(kept.size(), component_count));
  std::sort(kept.begin(), kept.end());
  Basis result{{.mean = basis.data.mean}, basis.spectrum, basis.function_count};
  int parity_class = 0, class_end = basis.data.class_count[0];
  for (const int k : kept) {
    while (k >= class_end) class_end += basis.data.class_count[++parity_class];
    ++result.data.class_count[parity_class];
    result.data.deviation.push_back(basis.data.deviation[k]);
    const auto row = basis.data.components.begin() + size_t(k) * kSize;
    result.data.components.insert(result.data.components.end(), row, row + kSize);
  }
  return result;
}

BasisData whitened(BasisData data, double whitening) {
  double square_sum = 0.0;  // of what is left of the deviations
  for (const float deviation : data.deviation) square_sum += std::pow(double{deviation}, 2.0 * (1.0 - whitening));
  const double scale = std::sqrt(square_sum / data.coefficientCount());
  for (float& deviation : data.deviation) deviation = static_cast<float>(std::pow(double{deviation}, whitening) * scale);
  return data;
}

std::vector<double> keptVariance(const Basis& basis, const uint8_t* phi, uint64_t function_count,
                                 const std::vector<int>& counts) {
  const int component_count = basis.data.coefficientCount();
  const std::vector<int> order = componentsByVariance(basis.data);
  std::vector<double> energy(component_count, 0.0);
  double total = 0.0;
  // with the training set's mean (docs/theory/math.md §3)
  for (uint64_t begin = 0; begin < function_count; begin += kBlockCount) {
    const int block = static_cast<int>(std::min<uint64_t>(kBlockCount, function_count - begin));
    std::vector<float> classes(size_t(block) * kClassStride);
    parityTransform(phi + begin * kSupportPointCount, block, classes.data());
    int first = 0;
    // by class, the energy that each component takes of the whole
    for (int c = 0; c < kParityClassCount; ++c) {
      Matrix rows = classRows(classes, block, c);
      rows.rowwise() -= Eigen::Map<const Eigen::RowVectorXf>(&basis.data.mean[size_t(c) * kSize], kSize).cast<double>();
      total += rows.squaredNorm();
      const int class_count = basis.data.class_count[c];
      if (class_count == 0) continue;
      const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> components(
          &basis.data.components[size_t(first) * kSize], class_count, kSize);
      const Matrix coefficients = rows * components.cast<double>().transpose();
      for (int k = 0; k < class_count; ++k) energy[first + k] += coefficients.col(k).squaredNorm();
      first += class_count;
    }
  }
  // by falling variance
  std::vector<double> kept;
  for (const int count : counts) {
    double sum = 0.0;
    for (int k = 0; k < std::min(count, component_count); ++k) sum += energy[order[k]];
    kept.push_back(total > 0 ? sum / total : 1.0);
  }
  return kept;
}

}  // namespace nlg
