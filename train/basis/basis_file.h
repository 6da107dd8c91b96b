// Reads and writes the file of the PCA basis (HDF5; layout in docs/reference/formats.md).
#pragma once

#include <string>

#include "tool/output_path.h"
#include "train/basis/basis_fit.h"

namespace nlg {

extern const OwnFiles kBasisFiles;

struct BasisFile {
  Basis basis;
  std::vector<float>
      mean_function;  // P, pattern order, [0, 1]: mean over those functions and their mirror images in which the point is valid
  std::vector<float> mean_validity;   // P: share of functions in which the point is valid, mirrored likewise
  std::vector<int32_t> kept_counts;   // component counts at which held-out variance was measured
  std::vector<double> kept_variance;  // share kept, one a count
  uint64_t pattern_hash = 0;
  std::string provenance_json;
};

// throws OutputError
void writeBasisFile(const std::string& path, const BasisFile& file);

// Compares the file's digest with every byte of it.
// throws InputError on a missing, damaged (DamageError) or foreign file (another pattern), counts that disagree, non-finite numbers
BasisFile readBasisFile(const std::string& path);

}  // namespace nlg
