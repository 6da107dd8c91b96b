// Digests of mutated files put right: a mutation would otherwise end there, and never reach what reads behind them. HDF5 files
// are written anew with theirs (hdf5_recipe.h), archives have checksums (zip_file.h).
#pragma once

#include <string>

namespace nlg::fuzz {

// Weights or a light grid with the `file_sha256` of its bytes, where it names one at all. Files of a length that is a multiple of 16
// are left as they are, so that a wrong one comes, too.
std::string withRightDigest(std::string safetensors);

}  // namespace nlg::fuzz
