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

// Whether a file is whole all the same: a safetensors file whose digest holds, of other tensors than were looked for, or an HDF5 file.
bool isOfAnotherKind(const std::string& path) {
  ByteSource source;
  if (!openByteSource(path, &source).ok()) return false;
  constexpr std::string_view kHdf5Begins = "\x89HDF\r\n\x1a\n";
  std::string begins(kHdf5Begins.size(), '\0');
  if (source.size >= begins.size() && source.read(0, begins.data(), begins.size()) && begins == kHdf5Begins) return true;
  const auto known = [](const std::string&, const std::string& dtype) {
    return std::string(dtypeBytes(dtype) > 0 ? "" : "an unknown dtype");
  };
  WeightsHeader header;
  uint64_t data_offset = 0;
  return readLayout(source, TensorAlignment::element, known, &header, &data_offset).ok() && header.digest_offset != 0;
}

}  // namespace

void requireRead(const std::string& path, const FileResult& result, const std::string& expected) {
  const char* status = fileStatusName(result.status);
  std::error_code error;
  if (!result.ok() && !std::filesystem::exists(path, error) && !error) throw InputError(path, "open", expected, kNoSuchFile);
  // the library's own lines begin with the path, as an error does
  const std::string prefix = path + ": ";
  const std::string got = result.detail.rfind(prefix, 0) == 0 ? result.detail.substr(prefix.size()) : result.detail;
  if (isDamage(result.status) && !isOfAnotherKind(path)) throw DamageError(path, status, expected, got);
  if (!result.ok()) throw InputError(path, status, expected, got);
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
