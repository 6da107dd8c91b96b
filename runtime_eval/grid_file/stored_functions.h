// The functions of a light grid in its file: function of each probe, theta, and dictionaries of codes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/grid_file/tensor_reading.h"
#include "runtime_eval/weights_file/tensor_file.h"

namespace nlg {

// A dictionary as a file has it: rows of the longest code, then c.
struct StoredDictionary {
  std::vector<int8_t> nodes, exponents;
};

// Tensors of the file. Those of bytes are coded (coded_bytes.h).
struct StoredFunctions {
  std::vector<uint32_t> probe_count;
  std::vector<uint8_t> probe_kind, probe_function, function_representation;
  // theta in int8, or in one of the others
  std::vector<uint8_t> groups, steps, step_halves;
  std::vector<Half> halves;
  std::vector<float> floats;
  std::vector<StoredDictionary> dictionaries;  // by representation; empty of those that are no codes
};

// grid      one that checkLightGrid accepts
// returns   ok; or value_out_of_range, the first theta beyond the precision, and what could be stored up to it
FileResult storeFunctions(const LightGrid& grid, ThetaPrecision precision, StoredFunctions* stored);

// stored   must stay where it is until the writer serializes
void addTensors(const StoredFunctions& stored, ThetaPrecision precision, TensorFileWriter* writer);

size_t thetaBytes(const StoredFunctions& stored);
size_t dictionaryBytes(const StoredFunctions& stored);

// The inverse: probe_function, function_representation, theta, and dictionaries of representations, whose names are known.
// counts   receives those of functions and probes; what light there is is known
FileResult readFunctions(const TensorFileReader& reader, GridCounts* counts, LightGrid* grid);

}  // namespace nlg
