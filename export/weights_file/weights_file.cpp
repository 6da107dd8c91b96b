#include "export/weights_file/weights_file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>

#include "export/weights_file/half.h"
#include "export/weights_file/header_parser.h"

static_assert(std::endian::native == std::endian::little, "tensors are copied as they lie in the file");

namespace nlg {
namespace {

constexpr uint64_t kLengthBytes = 8;
constexpr uint64_t kMaxHeaderBytes = uint64_t{1} << 20;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;
constexpr uint64_t kAlignment = 64;
constexpr std::string_view kPaddingPrefix = "padding.";

// Bytes that can be fetched piece by piece, so that a file is never in memory twice.
struct Source {
  uint64_t size = 0;
  std::function<bool(uint64_t offset, void* to, size_t count)> read;
};

WeightsResult refuse(WeightsStatus status, std::string detail) { return {status, std::move(detail)}; }
WeightsResult refuseTensor(WeightsStatus status, const std::string& name, const std::string& detail) {
  return {status, "tensor " + jsonQuoted(name) + ": " + detail};
}

bool isPadding(const std::string& name) { return std::string_view(name).substr(0, kPaddingPrefix.size()) == kPaddingPrefix; }

// Bytes of a tensor; false when they exceed 64 bits.
bool tensorBytes(const std::vector<uint64_t>& shape, uint64_t element_bytes, uint64_t* bytes) {
  *bytes = element_bytes;
  for (const uint64_t count : shape) {
    if (count != 0 && *bytes > std::numeric_limits<uint64_t>::max() / count) return false;
    *bytes *= count;
  }
  return true;
}

WeightsResult readHeader(const Source& source, WeightsHeader* header, uint64_t* data_offset) {
  uint64_t length = 0;
  if (source.size < kLengthBytes) return refuse(WeightsStatus::too_short, "no 8 bytes for the header's length");
  if (!source.read(0, &length, kLengthBytes)) return refuse(WeightsStatus::cannot_read, "header length");
  if (length > kMaxHeaderBytes || length > source.size - kLengthBytes) {
    return refuse(WeightsStatus::header_too_large,
                  "header of " + std::to_string(length) + " bytes in a file of " + std::to_string(source.size));
  }
  std::string text(length, '\0');
  if (!source.read(kLengthBytes, text.data(), length)) return refuse(WeightsStatus::cannot_read, "header");
  const std::string fault = parseWeightsHeader(text, header);
  if (!fault.empty()) return refuse(WeightsStatus::header_malformed, "header, " + fault);
  *data_offset = kLengthBytes + length;
  return {};
}

// One tensor by itself: dtype, alignment in the file, and a shape that fills its range exactly.
WeightsResult checkTensor(const std::string& name, const TensorEntry& tensor, uint64_t data_offset) {
  constexpr WeightsStatus kMalformed = WeightsStatus::tensor_malformed;
  const bool padding = isPadding(name), half = tensor.dtype == "F16";
  if (padding ? tensor.dtype != "U8" : !half && tensor.dtype != "F32") {
    return refuseTensor(kMalformed, name, std::string("dtype is not ") + (padding ? "U8" : "F32 or F16"));
  }
  uint64_t bytes = 0;
  if (!tensorBytes(tensor.shape, padding ? 1 : half ? sizeof(Half) : sizeof(float), &bytes))
    return refuseTensor(kMalformed, name, "shape too large");
  if (tensor.begin > tensor.end || tensor.end - tensor.begin != bytes) {
    return refuseTensor(kMalformed, name, "shape and data_offsets disagree");
  }
  // offsets beyond the file are refused later; here they must not wrap around
  const bool aligned = (data_offset % kAlignment + tensor.begin % kAlignment) % kAlignment == 0;
  if (!padding && !aligned) return refuseTensor(kMalformed, name, "does not start at a multiple of 64 bytes");
  return {};
}

// All tensors together must cover the data without a hole, an overlap or a rest: the rule of safetensors itself.
WeightsResult checkCoverage(const WeightsHeader& header, uint64_t data_bytes) {
  std::vector<std::pair<std::string_view, const TensorEntry*>> in_order;
  for (const auto& [name, tensor] : header.tensors) in_order.emplace_back(name, &tensor);
  std::sort(in_order.begin(), in_order.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second->begin, a.second->end) < std::pair(b.second->begin, b.second->end);
  });
  uint64_t covered = 0;
  for (const auto& [name, tensor] : in_order) {
    if (tensor->begin != covered) {
      const std::string what = tensor->begin < covered ? "overlaps" : "leaves a hole behind";
      return refuseTensor(WeightsStatus::tensor_malformed, std::string(name), what + " the tensor before it");
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

size_t elementBytes(WeightsDtype dtype) { return dtype == WeightsDtype::float16 ? sizeof(Half) : sizeof(float); }

// halves   as many as there are values; may lie in the values themselves, at their end
void widen(const char* halves, std::vector<float>* values) {
  for (size_t i = 0; i < values->size(); ++i) {
    Half half;
    std::memcpy(&half, halves + i * sizeof(Half), sizeof(Half));
    (*values)[i] = floatFromHalf(half);
  }
}

WeightsResult readTensor(const Source& source, const std::string& name, const TensorEntry& entry, uint64_t data_offset,
                         WeightsTensor* tensor) {
  tensor->shape = entry.shape;
  tensor->dtype = entry.dtype == "F16" ? WeightsDtype::float16 : WeightsDtype::float32;
  const size_t bytes = entry.end - entry.begin;
  tensor->values.resize(bytes / elementBytes(tensor->dtype));
  // halves are read into the upper half of their floats, so that widening from the front overwrites only what has been read
  char* first = reinterpret_cast<char*>(tensor->values.data()) + (tensor->values.size() * sizeof(float) - bytes);
  if (bytes > 0 && !source.read(data_offset + entry.begin, first, bytes)) {
    return refuseTensor(WeightsStatus::cannot_read, name, "read error");
  }
  if (tensor->dtype == WeightsDtype::float16) widen(first, &tensor->values);
  for (size_t i = 0; i < tensor->values.size(); ++i) {
    if (std::isfinite(tensor->values[i])) continue;
    return refuseTensor(WeightsStatus::value_not_finite, name, "value " + std::to_string(i));
  }
  return {};
}

WeightsResult readAll(const Source& source, WeightsFile* file) {
  WeightsHeader header;
  uint64_t data_offset = 0;
  WeightsResult result = readHeader(source, &header, &data_offset);
  if (!result.ok()) return result;
  for (const auto& [name, entry] : header.tensors) {
    result = checkTensor(name, entry, data_offset);
    if (!result.ok()) return result;
  }
  result = checkCoverage(header, source.size - data_offset);
  if (!result.ok()) return result;
  for (const auto& [name, entry] : header.tensors) {
    if (isPadding(name)) continue;
    result = readTensor(source, name, entry, data_offset, &file->tensors[name]);
    if (!result.ok()) return result;
  }
  file->metadata = std::move(header.metadata);
  return {};
}

WeightsResult readSource(const Source& source, WeightsFile* file) {
  *file = {};
  WeightsFile whole;
  const WeightsResult result = readAll(source, &whole);
  if (result.ok()) *file = std::move(whole);
  return result;
}

// The tensor's header entry; *offset moves behind its bytes.
std::string headerEntry(const std::string& name, const char* dtype, const std::vector<uint64_t>& shape, uint64_t bytes,
                        uint64_t* offset) {
  std::string text = jsonQuoted(name) + ":{\"dtype\":\"" + dtype + "\",\"shape\":[";
  for (size_t i = 0; i < shape.size(); ++i) text += (i > 0 ? "," : "") + std::to_string(shape[i]);
  text += "],\"data_offsets\":[" + std::to_string(*offset) + "," + std::to_string(*offset + bytes) + "]}";
  *offset += bytes;
  return text;
}

std::string metadataEntry(const std::map<std::string, std::string>& metadata) {
  std::string text = "\"__metadata__\":{";
  for (const auto& [key, value] : metadata) {
    if (text.back() != '{') text += ',';
    text += jsonQuoted(key) + ":" + jsonQuoted(value);
  }
  return text + "}";
}

void appendValues(const WeightsTensor& tensor, std::string* data) {
  if (tensor.dtype == WeightsDtype::float32) {
    data->append(reinterpret_cast<const char*>(tensor.values.data()), tensor.values.size() * sizeof(float));
    return;
  }
  for (const float value : tensor.values) {
    Half half{0x7e00};  // not a number, which readers refuse, for what is beyond float16
    halfFromFloat(value, &half);
    data->append(reinterpret_cast<const char*>(&half), sizeof half);
  }
}

uint64_t missingToAlignment(uint64_t bytes) { return (kAlignment - bytes % kAlignment) % kAlignment; }

}  // namespace

const char* weightsStatusName(WeightsStatus status) {
  switch (status) {
    case WeightsStatus::ok:
      return "ok";
    case WeightsStatus::cannot_open:
      return "cannot_open";
    case WeightsStatus::cannot_read:
      return "cannot_read";
    case WeightsStatus::too_short:
      return "too_short";
    case WeightsStatus::header_too_large:
      return "header_too_large";
    case WeightsStatus::header_malformed:
      return "header_malformed";
    case WeightsStatus::tensor_malformed:
      return "tensor_malformed";
    case WeightsStatus::tensor_missing:
      return "tensor_missing";
    case WeightsStatus::tensor_unexpected:
      return "tensor_unexpected";
    case WeightsStatus::value_not_finite:
      return "value_not_finite";
    case WeightsStatus::value_out_of_range:
      return "value_out_of_range";
    case WeightsStatus::version_unknown:
      return "version_unknown";
    case WeightsStatus::pattern_unknown:
      return "pattern_unknown";
    case WeightsStatus::simd_unavailable:
      return "simd_unavailable";
  }
  return "unknown";
}

WeightsResult readWeightsFile(const std::string& path, WeightsFile* file) {
  *file = {};
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(path.c_str(), "rb"), std::fclose);
  if (stream == nullptr) return refuse(WeightsStatus::cannot_open, path + ": " + std::strerror(errno));
  const bool at_end = std::fseek(stream.get(), 0, SEEK_END) == 0;
  const long size = at_end ? std::ftell(stream.get()) : -1;
  if (size < 0) return refuse(WeightsStatus::cannot_read, path + ": " + std::strerror(errno));
  if (static_cast<uint64_t>(size) > kMaxFileBytes) return refuse(WeightsStatus::cannot_read, path + ": larger than 1 GiB");
  const auto read = [&](uint64_t offset, void* to, size_t count) {
    return std::fseek(stream.get(), static_cast<long>(offset), SEEK_SET) == 0 && std::fread(to, 1, count, stream.get()) == count;
  };
  WeightsResult result = readSource({static_cast<uint64_t>(size), read}, file);
  if (!result.ok()) result.detail = path + ": " + result.detail;
  return result;
}

WeightsResult parseWeights(std::string_view bytes, WeightsFile* file) {
  const auto read = [&](uint64_t offset, void* to, size_t count) {
    std::memcpy(to, bytes.data() + offset, count);
    return true;
  };
  return readSource({bytes.size(), read}, file);
}

WeightsResult roundToFloat16(const std::string& name, WeightsTensor* tensor) {
  std::vector<float> rounded;
  rounded.reserve(tensor->values.size());
  for (const float value : tensor->values) {
    Half half;
    if (!halfFromFloat(value, &half)) {
      return refuseTensor(WeightsStatus::value_out_of_range, name,
                          "value " + std::to_string(rounded.size()) + " is beyond float16: " + std::to_string(value));
    }
    rounded.push_back(floatFromHalf(half));
  }
  tensor->values = std::move(rounded);
  tensor->dtype = WeightsDtype::float16;
  return {};
}

std::string serializeWeights(const WeightsFile& file) {
  std::string header = "{" + metadataEntry(file.metadata), data;
  uint64_t offset = 0, padding_count = 0;
  for (const auto& [name, tensor] : file.tensors) {
    const uint64_t padding_bytes = missingToAlignment(offset);
    if (padding_bytes > 0) {
      const std::string padding_name = std::string(kPaddingPrefix) + std::to_string(padding_count++);
      header += "," + headerEntry(padding_name, "U8", {padding_bytes}, padding_bytes, &offset);
      data.append(padding_bytes, '\0');
    }
    const size_t bytes = tensor.values.size() * elementBytes(tensor.dtype);
    header += "," + headerEntry(name, tensor.dtype == WeightsDtype::float16 ? "F16" : "F32", tensor.shape, bytes, &offset);
    appendValues(tensor, &data);
  }
  header += "}";
  header.append(missingToAlignment(kLengthBytes + header.size()), ' ');
  const uint64_t length = header.size();
  return std::string(reinterpret_cast<const char*>(&length), kLengthBytes) + header + data;
}

}  // namespace nlg
