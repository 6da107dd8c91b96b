// Reads tensors of a light grid's file one after another, until one is refused.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "runtime_eval/grid_file/grid_memory.h"
#include "runtime_eval/numbers/coded_bytes.h"
#include "runtime_eval/weights_file/safetensors_layout.h"
#include "runtime_eval/weights_file/tensor_file.h"

namespace nlg {

inline void takeFirst(FileResult* result, FileResult next) {
  if (result->ok()) *result = std::move(next);
}

inline FileResult refuseCount(const std::string& tensor, size_t expected, size_t got) {
  return refuse(FileStatus::tensor_unexpected,
                tensor + ": expected " + std::to_string(expected) + " values, got " + std::to_string(got));
}

// A tensor of exactly kCount numbers.
template <size_t kCount, class T>
FileResult readNumbers(const TensorFileReader& reader, const std::string& name, T* numbers) {
  std::vector<T> values;
  FileResult result = reader.read(name, &values);
  if (!result.ok()) return result;
  if (values.size() != kCount) return refuseCount(name, kCount, values.size());
  std::copy(values.begin(), values.end(), numbers);
  return {};
}

inline FileResult checkMemory(const TensorFileReader& reader, const GridCounts& counts) {
  const uint64_t most = mostGridMemory(reader.byteCount());
  if (counts.memory() <= most) return {};
  return refuse(FileStatus::value_out_of_range, "memory: expected a grid of at most " + std::to_string(most) +
                                                    " bytes for a file of " + std::to_string(reader.byteCount()) +
                                                    " bytes, got a larger one; bake it again");
}

// A tensor of bytes that codedBytes made, of which there are columns, or at most so many.
inline FileResult readCoded(const TensorFileReader& reader, const std::string& name, const std::vector<uint16_t>& columns,
                            std::vector<uint8_t>* bytes, size_t most = kMaxCodedBytes) {
  std::vector<uint8_t> coded;
  FileResult result = reader.read(name, &coded);
  if (!result.ok() || decodeBytes(coded, columns, bytes, most)) return result;
  return refuse(FileStatus::tensor_unexpected,
                name + ": not the code of " +
                    (columns.empty() ? "at most " + std::to_string(most) : std::to_string(columns.size())) + " bytes");
}

}  // namespace nlg
