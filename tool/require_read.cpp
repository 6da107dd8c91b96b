#include "tool/require_read.h"

#include <filesystem>
#include <iostream>
#include <mutex>
#include <set>
#include <string_view>

#include "runtime_eval/weights_file/safetensors_layout.h"
#include "tool/error.h"

namespace nlg {
namespace {

// What the bytes themselves prove: no writer of ours left them so.
bool isDamage(FileStatus status) {
  return status == FileStatus::too_short || status == FileStatus::header_too_large || status == FileStatus::header_malformed ||
         status == FileStatus::tensor_malformed || status == FileStatus::digest_mismatch;
}

// What a file is that is whole all the same, in words; empty where it is nothing that is known.
std::string otherKind(const std::string& path) {
  ByteSource source;
  if (!openByteSource(path, &source).ok()) return "";
  constexpr std::string_view kHdf5Begins = "\x89HDF\r\n\x1a\n", kOnnxBegins = "\x08";
  std::string begins(kHdf5Begins.size(), '\0');
  if (source.size >= begins.size() && source.read(0, begins.data(), begins.size())) {
    if (begins == kHdf5Begins) return "an HDF5 file, a shard or a basis";
    // the field ir_version of a model
    if (begins.starts_with(kOnnxBegins) && path.ends_with(".onnx"))
      return "an ONNX model, for other runtimes; its weights file is read here";
  }
  const auto known = [](const std::string&, const std::string& dtype) {
    return std::string(dtypeBytes(dtype) > 0 ? "" : "an unknown dtype");
  };
  WeightsHeader header;
  uint64_t data_offset = 0;
  if (!readLayout(source, TensorAlignment::element, known, &header, &data_offset).ok() || header.digest_offset == 0) return "";
  const auto kind = header.metadata.find("kind");
  if (kind != header.metadata.end() && kind->second.starts_with("nlg-checkpoint"))
    return "a checkpoint of nlg-train, of which nlg-export makes weights";
  return "a whole file of other tensors";
}

}  // namespace

void requireRead(const std::string& path, const FileResult& result, const std::string& expected) {
  const char* status = fileStatusName(result.status);
  std::error_code error;
  if (!result.ok() && !std::filesystem::exists(path, error) && !error) throw InputError(path, "open", expected, kNoSuchFile);
  // the library's own lines begin with the path, as an error does
  const std::string prefix = path + ": ";
  const std::string got = result.detail.rfind(prefix, 0) == 0 ? result.detail.substr(prefix.size()) : result.detail;
  if (!result.ok()) {
    const std::string kind = otherKind(path);
    if (isDamage(result.status) && kind.empty()) throw DamageError(path, status, expected, got);
    throw InputError(path, status, expected, kind.empty() ? got : kind + ": " + got);
  }
  if (!result.detail.empty()) sayUnchecked(result.detail);
}

void sayUnchecked(const std::string& line) {
  // some tools read a file twice
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  if (said.insert(line).second) std::cerr << "unchecked: " << line << '\n';
}

}  // namespace nlg
