#include "export/weights_file/tensor_file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

static_assert(std::endian::native == std::endian::little, "tensors are copied as they lie in the file");

namespace nlg {
namespace {

constexpr uint64_t kLengthBytes = 8;
constexpr uint64_t kMaxHeaderBytes = uint64_t{1} << 20;
constexpr uint64_t kAlignment = 64;
constexpr std::string_view kPaddingPrefix = "padding.";

WeightsResult refuse(WeightsStatus status, std::string detail) { return {status, std::move(detail)}; }
WeightsResult refuseTensor(WeightsStatus status, const std::string& name, const std::string& detail) {
  return {status, "tensor " + jsonQuoted(name) + ": " + detail};
}

bool isPadding(std::string_view name) { return name.substr(0, kPaddingPrefix.size()) == kPaddingPrefix; }
uint64_t missingToAlignment(uint64_t bytes) { return (kAlignment - bytes % kAlignment) % kAlignment; }

// 0 for a dtype that no tensor here may have.
uint64_t elementBytes(std::string_view dtype) {
  constexpr std::pair<std::string_view, uint64_t> kTypes[] = {{"U8", 1},  {"U32", 4}, {"U64", 8}, {"I32", 4},
                                                              {"F16", 2}, {"F32", 4}, {"F64", 8}};
  for (const auto& [name, bytes] : kTypes)
    if (name == dtype) return bytes;
  return 0;
}

// One tensor by itself: dtype, alignment in the file, and a shape that fills its range exactly.
WeightsResult checkTensor(const std::string& name, const TensorEntry& tensor, uint64_t data_offset) {
  constexpr WeightsStatus kMalformed = WeightsStatus::tensor_malformed;
  uint64_t bytes = elementBytes(tensor.dtype);
  if (bytes == 0) return refuseTensor(kMalformed, name, "dtype is none of U8, U32, U64, I32, F16, F32, F64");
  for (const uint64_t count : tensor.shape) {
    if (count != 0 && bytes > std::numeric_limits<uint64_t>::max() / count)
      return refuseTensor(kMalformed, name, "shape too large");
    bytes *= count;
  }
  if (tensor.begin > tensor.end || tensor.end - tensor.begin != bytes)
    return refuseTensor(kMalformed, name, "shape and data_offsets disagree");
  // offsets beyond the file are refused later; here they must not wrap around
  const bool aligned = (data_offset % kAlignment + tensor.begin % kAlignment) % kAlignment == 0;
  if (!isPadding(name) && !aligned) return refuseTensor(kMalformed, name, "does not start at a multiple of 64 bytes");
  return {};
}

// All tensors together must cover the data without a hole, an overlap or a rest: the rule of safetensors itself.
WeightsResult checkCoverage(const WeightsHeader& header, uint64_t data_bytes) {
  std::vector<std::pair<const TensorEntry*, const std::string*>> in_order;
  for (const auto& [name, tensor] : header.tensors) in_order.emplace_back(&tensor, &name);
  std::sort(in_order.begin(), in_order.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first->begin, a.first->end) < std::pair(b.first->begin, b.first->end);
  });
  uint64_t covered = 0;
  for (const auto& [tensor, name] : in_order) {
    if (tensor->begin != covered) {
      const std::string what = tensor->begin < covered ? "overlaps" : "leaves a hole behind";
      return refuseTensor(WeightsStatus::tensor_malformed, *name, what + " the tensor before it");
    }
    covered = tensor->end;
  }
  if (covered > data_bytes) {
    return refuse(WeightsStatus::too_short,
                  "tensors of " + std::to_string(covered) + " bytes, " + std::to_string(data_bytes) + " are there");
  }
  if (covered < data_bytes) return refuse(WeightsStatus::tensor_malformed, "bytes behind the last tensor");
  return {};
}

// The tensor's header entry; *offset moves behind its bytes.
std::string headerEntry(const std::string& name, const char* dtype, uint64_t count, uint64_t bytes, uint64_t* offset) {
  const std::string begin = std::to_string(*offset);
  *offset += bytes;
  return "," + jsonQuoted(name) + ":{\"dtype\":\"" + dtype + "\",\"shape\":[" + std::to_string(count) + "],\"data_offsets\":[" +
         begin + "," + std::to_string(*offset) + "]}";
}

}  // namespace

WeightsResult TensorFileReader::openFile(const std::string& path) {
  *this = {};
  const std::shared_ptr<std::FILE> stream(std::fopen(path.c_str(), "rb"), [](std::FILE* file) {
    if (file != nullptr) std::fclose(file);
  });
  if (stream == nullptr) return refuse(WeightsStatus::cannot_open, std::strerror(errno));
  const bool at_end = std::fseek(stream.get(), 0, SEEK_END) == 0;
  const long size = at_end ? std::ftell(stream.get()) : -1;
  if (size < 0) return refuse(WeightsStatus::cannot_read, std::strerror(errno));
  return open(static_cast<uint64_t>(size), [stream](uint64_t offset, void* to, size_t count) {
    return std::fseek(stream.get(), static_cast<long>(offset), SEEK_SET) == 0 && std::fread(to, 1, count, stream.get()) == count;
  });
}

WeightsResult TensorFileReader::openBytes(std::string_view bytes) {
  *this = {};
  return open(bytes.size(), [bytes](uint64_t offset, void* to, size_t count) {
    std::memcpy(to, bytes.data() + offset, count);
    return true;
  });
}

WeightsResult TensorFileReader::open(uint64_t size, Read read) {
  if (size > kMaxTensorFileBytes) return refuse(WeightsStatus::cannot_read, "larger than 16 GiB");
  uint64_t length = 0;
  if (size < kLengthBytes) return refuse(WeightsStatus::too_short, "no 8 bytes for the header's length");
  if (!read(0, &length, kLengthBytes)) return refuse(WeightsStatus::cannot_read, "header length");
  if (length > kMaxHeaderBytes || length > size - kLengthBytes) {
    return refuse(WeightsStatus::header_too_large,
                  "header of " + std::to_string(length) + " bytes in a file of " + std::to_string(size));
  }
  std::string text(length, '\0');
  if (!read(kLengthBytes, text.data(), length)) return refuse(WeightsStatus::cannot_read, "header");
  WeightsHeader header;
  const std::string fault = parseWeightsHeader(text, &header);
  if (!fault.empty()) return refuse(WeightsStatus::header_malformed, "header, " + fault);
  const uint64_t data_offset = kLengthBytes + length;
  for (const auto& [name, tensor] : header.tensors) {
    WeightsResult result = checkTensor(name, tensor, data_offset);
    if (!result.ok()) return result;
  }
  WeightsResult result = checkCoverage(header, size - data_offset);
  if (!result.ok()) return result;
  header_ = std::move(header);
  data_offset_ = data_offset;
  read_ = std::move(read);
  return {};
}

std::string_view TensorFileReader::dtypeOf(const std::string& name) const {
  const auto found = header_.tensors.find(name);
  return found == header_.tensors.end() ? std::string_view() : found->second.dtype;
}

WeightsResult TensorFileReader::find(const std::string& name, const char* dtype, const TensorEntry** entry) const {
  const auto found = header_.tensors.find(name);
  if (found == header_.tensors.end()) return refuse(WeightsStatus::tensor_missing, "no tensor " + name);
  const TensorEntry& tensor = found->second;
  if (tensor.dtype != dtype) {
    return refuse(WeightsStatus::tensor_unexpected, name + ": expected dtype " + dtype + ", got " + tensor.dtype);
  }
  if (tensor.shape.size() != 1) {
    return refuse(WeightsStatus::tensor_unexpected,
                  name + ": expected one dimension, got " + std::to_string(tensor.shape.size()));
  }
  *entry = &tensor;
  return {};
}

WeightsResult TensorFileReader::fetch(const std::string& name, const TensorEntry& entry, void* to) const {
  const uint64_t bytes = entry.end - entry.begin;
  if (bytes == 0 || read_(data_offset_ + entry.begin, to, bytes)) return {};
  return refuseTensor(WeightsStatus::cannot_read, name, "read error");
}

WeightsResult TensorFileWriter::serialize(const std::map<std::string, std::string>& metadata, std::string* bytes) const {
  bytes->clear();
  std::string header = "{\"__metadata__\":{";
  for (const auto& [key, value] : metadata) {
    if (header.back() != '{') header += ',';
    header += jsonQuoted(key) + ":" + jsonQuoted(value);
  }
  header += '}';
  uint64_t offset = 0, padding_count = 0;
  for (const Tensor& tensor : tensors_) {
    const uint64_t padding = missingToAlignment(offset);
    if (padding > 0)
      header += headerEntry(std::string(kPaddingPrefix) + std::to_string(padding_count++), "U8", padding, padding, &offset);
    header += headerEntry(tensor.name, tensor.dtype, tensor.count, tensor.bytes, &offset);
  }
  header += "}";
  header.append(missingToAlignment(kLengthBytes + header.size()), ' ');
  const uint64_t length = header.size();
  if (length > kMaxHeaderBytes) return refuse(WeightsStatus::header_too_large, "header of " + std::to_string(length) + " bytes");
  WeightsHeader parsed;
  const std::string fault = parseWeightsHeader(header, &parsed);
  if (!fault.empty()) return refuse(WeightsStatus::header_malformed, "header, " + fault);

  bytes->reserve(kLengthBytes + length + offset);
  bytes->append(reinterpret_cast<const char*>(&length), kLengthBytes).append(header);
  for (const Tensor& tensor : tensors_) {
    // the header ends at a multiple too, so that the file's length tells
    bytes->append(missingToAlignment(bytes->size()), '\0');
    if (tensor.bytes > 0) bytes->append(static_cast<const char*>(tensor.values), tensor.bytes);
  }
  return {};
}

}  // namespace nlg
