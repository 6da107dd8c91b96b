// Reads tensors of a light grid's file one after another, until one is refused.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "nlg/light_grid.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/coded_bytes.h"
#include "runtime_eval/weights_file/safetensors_layout.h"
#include "runtime_eval/weights_file/tensor_file.h"

namespace nlg {

// Limits the memory of a light grid while it is read, by the bytes of its file: a few kilobytes of coded bytes could ask for a
// million probes. A writer lengthens a file whose grid would need more.
inline constexpr uint64_t kSmallGridFile = 1'000'000;
// 48 MB, and 8 times its bytes, a file of less than 1 MB may ask for; for each byte more 256.
constexpr uint64_t mostGridMemory(uint64_t file_bytes) {
  const uint64_t small = std::min(file_bytes, kSmallGridFile);
  return 48'000'000 + 8 * small + 256 * (file_bytes - small);
}

inline constexpr uint64_t kLeastOfFunction = 48, kLeastOfNode = 80;

// How much there is of a grid.
struct GridCounts {
  std::vector<Representation> representations;
  uint64_t functions = 0, probes = 0, nodes = 0, slots = 0;
  uint64_t light_groups = 0;  // 1 where all light is one, 0 without any
  uint64_t words = 0;         // of a record of light
  uint64_t fields = 0;        // of numbers, each of which takes time, too: a tenth of a microsecond

  // Not less than a reader takes, bytes.
  uint64_t memory() const {
    constexpr uint64_t kLight = kShFloats * sizeof(float), kOfNumber = 6;
    uint64_t dictionaries = 0, theta = 0;
    for (const Representation& representation : representations) {
      const auto numbers = static_cast<uint64_t>(representation.thetaCount());
      dictionaries += representation.isCode() ? (numbers + 1) * 6 * kMaxBrickNodes : 0;
      theta = std::max(theta, representation.isCode() ? 4 * numbers + 4 * kMaxQuads : 16 * numbers);
    }
    const uint64_t lights = light_groups > 1 ? light_groups + 1 : light_groups, records = probes * light_groups;
    const uint64_t of_probe = 64 + (light_groups > 0 ? 64 : 0) + kLight * lights;
    const uint64_t bytes =
        dictionaries + functions * (kLeastOfFunction + theta) + probes * of_probe + kLeastOfNode * nodes + 4 * slots;
    return std::max(bytes + records * (4 * words + 2 * fields), records * fields * kOfNumber);
  }
};

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
