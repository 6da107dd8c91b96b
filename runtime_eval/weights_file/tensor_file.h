// Reads and writes lists of numbers of several types in one safetensors file; weights_file.h is for F32 only.
//
// The same rules, but that a tensor starts at a multiple of the size of its elements: fillers of dtype U8 named "padding.0",
// "padding.1", … stand where bytes are skipped, spaces end the header, nothing overlaps and nothing is left over. Every tensor has one
// dimension.
// No exceptions, no dependency; statuses and results are those of nlg/result.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "nlg/result.h"
#include "runtime_eval/numbers/half.h"
#include "runtime_eval/weights_file/header_parser.h"

namespace nlg {

struct ByteSource;

inline constexpr uint64_t kMaxTensorFileBytes = uint64_t{1} << 34;

// The dtype of a type in memory: "U8", "U16", "U32", "U64", "I8", "I32", "F16", "F32" or "F64".
template <class T>
constexpr const char* tensorDtype() {
  if constexpr (std::is_same_v<T, uint8_t>) return "U8";
  if constexpr (std::is_same_v<T, uint16_t>) return "U16";
  if constexpr (std::is_same_v<T, uint32_t>) return "U32";
  if constexpr (std::is_same_v<T, uint64_t>) return "U64";
  if constexpr (std::is_same_v<T, int8_t>) return "I8";
  if constexpr (std::is_same_v<T, int32_t>) return "I32";
  if constexpr (std::is_same_v<T, Half>) return "F16";
  if constexpr (std::is_same_v<T, float>) return "F32";
  if constexpr (std::is_same_v<T, double>) return "F64";
}

// Opens a file and checks its header against its size: dtypes, shapes, alignment, that the tensors cover all bytes; then the digest,
// where the file names one, against all of them. Values are fetched one tensor at a time; nothing is allocated that the file does not cover. What values mean is for the caller.
class TensorFileReader {
 public:
  FileResult openFile(const std::string& path);
  // bytes   must outlive the reader
  FileResult openBytes(std::string_view bytes);

  // But for the digest, which openFile and openBytes have compared with every byte.
  const std::map<std::string, std::string>& metadata() const { return header_.metadata; }
  // Of all that was opened.
  uint64_t byteCount() const { return byte_count_; }
  bool hasDigest() const { return header_.digest_offset > 0; }
  // The dtype of a tensor; empty when there is none of that name.
  std::string_view dtypeOf(const std::string& name) const;

  // Reads a whole tensor. Refused: no tensor of that name (tensor_missing), of another dtype or number of dimensions
  // (tensor_unexpected), a read error (cannot_read).
  template <class T>
  FileResult read(const std::string& name, std::vector<T>* values) const {
    static_assert(std::is_trivially_copyable_v<T>);
    const TensorEntry* entry = nullptr;
    FileResult result = find(name, tensorDtype<T>(), &entry);
    if (!result.ok()) return result;
    values->resize((entry->end - entry->begin) / sizeof(T));
    return fetch(name, *entry, values->data());
  }

 private:
  FileResult open(ByteSource source);
  FileResult find(const std::string& name, const char* dtype, const TensorEntry** entry) const;
  FileResult fetch(const std::string& name, const TensorEntry& entry, void* to) const;

  WeightsHeader header_;
  uint64_t data_offset_ = 0, byte_count_ = 0;
  std::function<bool(uint64_t offset, void* to, size_t count)> read_;
};

// Collects tensors, then lays out the file. The same calls give the same bytes.
class TensorFileWriter {
 public:
  // values   must stay where they are until serialize
  // name     UTF-8, not given before, not "__metadata__" or "padding.…"
  template <class T>
  void add(const std::string& name, const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    tensors_.push_back({name, tensorDtype<T>(), values.data(), values.size(), values.size() * sizeof(T)});
  }

  // The bytes of a file, tensors in the order they were added. Refused: what no reader would take, texts that are no UTF-8
  // (header_malformed) or more than 1 MiB of header (header_too_large). On failure *bytes is empty.
  FileResult serialize(const std::map<std::string, std::string>& metadata, std::string* bytes) const;

 private:
  struct Tensor {
    std::string name;
    const char* dtype;
    const void* values;
    size_t count, bytes;
  };
  std::vector<Tensor> tensors_;
};

}  // namespace nlg
