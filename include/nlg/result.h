// What became of reading or checking a file, or what stands in one: the status of weights, light grids, checkpoints and whatever else
// runtime_eval reads.
#pragma once

#include <string>

namespace nlg {

enum class FileStatus {
  ok,
  cannot_open,        // the system refused, or it is no regular file: a pipe, a device, a folder
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
  digest_mismatch,   // the file's bytes are not those that its SHA-256 is of: damaged
};

// A short English name of a status, for messages: "tensor_missing"; "unknown" for a number that is no status.
const char* fileStatusName(FileStatus status);

// A status and, when it is not ok, one line that says where and why. A reader's ok has an empty text, or says that the file names no
// digest, so that nobody knows whether it is damaged: a safetensors file that is none of this project.
struct FileResult {
  FileStatus status = FileStatus::ok;
  std::string detail;
  bool ok() const { return status == FileStatus::ok; }
};

}  // namespace nlg
