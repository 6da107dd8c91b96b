#include "runtime_eval/weights_file/weights_file.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "runtime_eval/numbers/half.h"
#include "runtime_eval/weights_file/safetensors_layout.h"

static_assert(std::endian::native == std::endian::little, "tensors are copied as they lie in the file");

namespace nlg {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;

std::string weightsDtypeFault(const std::string& name, const std::string& dtype) {
  if (isPadding(name)) return dtype == "U8" ? "" : "dtype is not U8";
  return dtype == "F16" || dtype == "F32" ? "" : "dtype is not F32 or F16";
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

FileResult readTensor(const ByteSource& source, const std::string& name, const TensorEntry& entry, uint64_t data_offset,
                      WeightsTensor* tensor) {
  tensor->shape = entry.shape;
  tensor->dtype = entry.dtype == "F16" ? WeightsDtype::float16 : WeightsDtype::float32;
  const size_t bytes = entry.end - entry.begin;
  tensor->values.resize(bytes / elementBytes(tensor->dtype));
  // halves are read into the upper half of their floats, so that widening from the front overwrites only what has been read
  char* first = reinterpret_cast<char*>(tensor->values.data()) + (tensor->values.size() * sizeof(float) - bytes);
  if (bytes > 0 && !source.read(data_offset + entry.begin, first, bytes)) {
    return refuseTensor(FileStatus::cannot_read, name, "read error");
  }
  if (tensor->dtype == WeightsDtype::float16) widen(first, &tensor->values);
  for (size_t i = 0; i < tensor->values.size(); ++i) {
    if (std::isfinite(tensor->values[i])) continue;
    return refuseTensor(FileStatus::value_not_finite, name, "value " + std::to_string(i));
  }
  return {};
}

FileResult readAll(const ByteSource& source, WeightsFile* file) {
  WeightsHeader header;
  uint64_t data_offset = 0;
  FileResult opened = readLayout(source, TensorAlignment::line, weightsDtypeFault, &header, &data_offset);
  if (!opened.ok()) return opened;
  // damage may have taken it away
  const bool is_generator = header.metadata.count("version") != 0;
  if (header.digest_offset == 0 && is_generator) return refuse(FileStatus::digest_mismatch, kDigestMissing);
  for (const auto& [name, entry] : header.tensors) {
    if (isPadding(name)) continue;
    FileResult result = readTensor(source, name, entry, data_offset, &file->tensors[name]);
    if (!result.ok()) return result;
  }
  file->metadata = std::move(header.metadata);
  return opened;
}

FileResult readSource(const ByteSource& source, WeightsFile* file) {
  *file = {};
  WeightsFile whole;
  FileResult result = readAll(source, &whole);
  if (result.ok()) *file = std::move(whole);
  return result;
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

}  // namespace

FileResult readWeightsFile(const std::string& path, WeightsFile* file) {
  *file = {};
  ByteSource source;
  FileResult result = openByteSource(path, &source);
  if (result.ok() && source.size > kMaxFileBytes) result = refuse(FileStatus::cannot_read, "larger than 1 GiB");
  if (result.ok()) result = readSource(source, file);
  if (!result.detail.empty()) result.detail = path + ": " + result.detail;
  return result;
}

FileResult parseWeights(std::string_view bytes, WeightsFile* file) { return readSource(byteSource(bytes), file); }

FileResult roundToFloat16(const std::string& name, WeightsTensor* tensor) {
  std::vector<float> rounded;
  rounded.reserve(tensor->values.size());
  for (const float value : tensor->values) {
    Half half;
    if (!halfFromFloat(value, &half)) {
      return refuseTensor(FileStatus::value_out_of_range, name,
                          "value " + std::to_string(rounded.size()) + " is beyond float16: " + std::to_string(value));
    }
    rounded.push_back(floatFromHalf(half));
  }
  tensor->values = std::move(rounded);
  tensor->dtype = WeightsDtype::float16;
  return {};
}

std::string serializeWeights(const WeightsFile& file) {
  HeaderWriter header(file.metadata, TensorAlignment::line);
  std::string data;
  for (const auto& [name, tensor] : file.tensors) {
    const size_t bytes = tensor.values.size() * elementBytes(tensor.dtype);
    const char* dtype = tensor.dtype == WeightsDtype::float16 ? "F16" : "F32";
    data.append(header.add(name, dtype, tensor.shape, bytes), '\0');
    appendValues(tensor, &data);
  }
  std::string bytes = withLength(header.finish()) + data;
  stampDigest(&bytes);
  return bytes;
}

}  // namespace nlg
