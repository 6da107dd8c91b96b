#include "runtime_eval/weights_file/tensor_file.h"

#include "runtime_eval/weights_file/safetensors_layout.h"

namespace nlg {
namespace {

std::string plainDtypeFault(const std::string&, const std::string& dtype) {
  return dtypeBytes(dtype) > 0 ? "" : "dtype is none of U8, U16, U32, U64, I8, I32, F16, F32, F64";
}

}  // namespace

FileResult TensorFileReader::openFile(const std::string& path) {
  *this = {};
  ByteSource source;
  const FileResult result = openByteSource(path, &source);
  return result.ok() ? open(std::move(source)) : result;
}

FileResult TensorFileReader::openBytes(std::string_view bytes) {
  *this = {};
  return open(byteSource(bytes));
}

FileResult TensorFileReader::open(ByteSource source) {
  if (source.size > kMaxTensorFileBytes) return refuse(FileStatus::cannot_read, "larger than 16 GiB");
  WeightsHeader header;
  uint64_t data_offset = 0;
  const FileResult result = readLayout(source, TensorAlignment::element, plainDtypeFault, &header, &data_offset);
  if (!result.ok()) return result;
  header_ = std::move(header);
  data_offset_ = data_offset;
  byte_count_ = source.size;
  read_ = std::move(source.read);
  return result;
}

std::string_view TensorFileReader::dtypeOf(const std::string& name) const {
  const auto found = header_.tensors.find(name);
  return found == header_.tensors.end() ? std::string_view() : found->second.dtype;
}

FileResult TensorFileReader::find(const std::string& name, const char* dtype, const TensorEntry** entry) const {
  const auto found = header_.tensors.find(name);
  if (found == header_.tensors.end()) return refuse(FileStatus::tensor_missing, "no tensor " + name);
  const TensorEntry& tensor = found->second;
  if (tensor.dtype != dtype) {
    return refuse(FileStatus::tensor_unexpected, name + ": expected dtype " + dtype + ", got " + tensor.dtype);
  }
  if (tensor.shape.size() != 1) {
    return refuse(FileStatus::tensor_unexpected, name + ": expected one dimension, got " + std::to_string(tensor.shape.size()));
  }
  *entry = &tensor;
  return {};
}

FileResult TensorFileReader::fetch(const std::string& name, const TensorEntry& entry, void* to) const {
  const uint64_t bytes = entry.end - entry.begin;
  if (bytes == 0 || read_(data_offset_ + entry.begin, to, bytes)) return {};
  return refuseTensor(FileStatus::cannot_read, name, "read error");
}

FileResult TensorFileWriter::serialize(const std::map<std::string, std::string>& metadata, std::string* bytes) const {
  bytes->clear();
  HeaderWriter writer(metadata, TensorAlignment::element);
  std::vector<uint64_t> padding;
  uint64_t data_bytes = 0;
  for (const Tensor& tensor : tensors_) {
    padding.push_back(writer.add(tensor.name, tensor.dtype, {tensor.count}, tensor.bytes));
    data_bytes += padding.back() + tensor.bytes;
  }
  const std::string header = writer.finish();
  if (header.size() > kMaxHeaderBytes) {
    return refuse(FileStatus::header_too_large, "header of " + std::to_string(header.size()) + " bytes");
  }
  // the caller's texts may be no UTF-8: nothing is written that a reader would refuse
  WeightsHeader parsed;
  const std::string fault = parseWeightsHeader(header, &parsed);
  if (!fault.empty()) return refuse(FileStatus::header_malformed, "header, " + fault);

  *bytes = withLength(header);
  bytes->reserve(bytes->size() + data_bytes);
  for (size_t i = 0; i < tensors_.size(); ++i) {
    bytes->append(padding[i], '\0');
    if (tensors_[i].bytes > 0) bytes->append(static_cast<const char*>(tensors_[i].values), tensors_[i].bytes);
  }
  // last, because it covers all other bytes
  stampDigest(bytes);
  return {};
}

}  // namespace nlg
