// The result of reading or checking a file, such as weights or a light grid: a status, and one line that says where and why.
#pragma once

#include <string>

namespace nlg {

enum class FileStatus {
  ok,
  cannot_open,        // the system refused, or the path is not a regular file but a pipe, a device or a folder
  cannot_read,        // the system refused, or the file is too large: weights above 1 GiB, other files above 16 GiB
  too_short,          // no header length, or fewer bytes than the tensors of the header need
  header_too_large,   // header length above 1 MiB or past the end of the file
  header_malformed,   // no JSON object of the form that safetensors prescribes
  tensor_malformed,   // another dtype, shape and bytes disagree, overlap, hole, misaligned, or bytes behind the last tensor
  tensor_missing,     // a tensor or metadata key that is needed is not there
  tensor_unexpected,  // a tensor of another dtype or shape than is needed
  value_not_finite,
  value_out_of_range,
  version_unknown,
  pattern_unknown,   // made for another support pattern
  simd_unavailable,  // NLG_SIMD names a target that this build or machine does not have
  digest_mismatch,   // the bytes do not match the file's SHA-256: it is damaged
};

// Returns a short English name for messages, as "tensor_missing"; "unknown" for a number that is no status.
const char* fileStatusName(FileStatus status);

// A status and, if it is not ok, one line that says where and why. With ok the line is empty, or says that the file has no
// digest, so that damage cannot be detected: a safetensors file that this project did not write.
struct FileResult {
  FileStatus status = FileStatus::ok;
  std::string detail;
  bool ok() const { return status == FileStatus::ok; }
};

}  // namespace nlg
