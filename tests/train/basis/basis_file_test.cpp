#include "train/basis/basis_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/damage.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

// HDF5 1.10.8 itself loses some hundred bytes for each damaged file that it refuses.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace nlg {
namespace {

BasisFile sampleFile() {
  BasisFile file;
  file.basis.data = sampleBasis(kSampleClasses, 1);
  file.basis.function_count = 321;
  for (int i = 0; i < kSupportPointCount; ++i) {
    file.basis.spectrum.push_back(1.0 / (i + 1));
    file.mean_function.push_back(static_cast<float>(i) / kSupportPointCount);
    file.mean_validity.push_back(1.0f - static_cast<float>(i) / kSupportPointCount);
  }
  file.kept_counts = {32, 64};
  file.kept_variance = {0.5, 0.75};
  file.pattern_hash = supportPattern().hash;
  file.provenance_json = R"({"tool":"nlg-pca"})";
  return file;
}

class BasisFileOnDisk : public testing::Test {
 protected:
  bool refused() const {
    const std::string error = inputErrorOf([&] { readBasisFile(path_); });
    if (error == "no error") return false;
    EXPECT_EQ(error.rfind(path_, 0), 0u) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return true;
  }

  template <class Change>
  bool refusedAfter(const Change& change) const {
    BasisFile file = sampleFile();
    change(file);
    writeBasisFile(path_, file);
    return refused();
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "basis.h5";
};

TEST_F(BasisFileOnDisk, RoundTrips) {
  const BasisFile file = sampleFile();
  writeBasisFile(path_, file);
  const BasisFile read = readBasisFile(path_);
  EXPECT_EQ(read.basis.data.class_count, file.basis.data.class_count);
  EXPECT_EQ(read.basis.data.mean, file.basis.data.mean);
  EXPECT_EQ(read.basis.data.components, file.basis.data.components);
  EXPECT_EQ(read.basis.data.deviation, file.basis.data.deviation);
  EXPECT_EQ(read.basis.spectrum, file.basis.spectrum);
  EXPECT_EQ(read.basis.function_count, file.basis.function_count);
  EXPECT_EQ(read.mean_function, file.mean_function);
  EXPECT_EQ(read.mean_validity, file.mean_validity);
  EXPECT_EQ(read.kept_counts, file.kept_counts);
  EXPECT_EQ(read.kept_variance, file.kept_variance);
  EXPECT_EQ(read.pattern_hash, file.pattern_hash);
  EXPECT_EQ(read.provenance_json, file.provenance_json);
}

TEST_F(BasisFileOnDisk, RefusesWhatIsDamaged) {
  writeBasisFile(path_, sampleFile());
  const std::string whole = readFile(path_);
  const auto said = [&](const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return refused() ? "refused" : "";
  };
  expectDamageIsRefused(whole, said, whole.size() / 61);
}

}  // namespace
}  // namespace nlg
