// The layout of safetensors files: header and tensors. weights_file.h and tensor_file.h define which tensors there are and
// what they mean.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "nlg/result.h"
#include "runtime_eval/weights_file/header_parser.h"

namespace nlg {

inline constexpr uint64_t kMaxHeaderBytes = uint64_t{1} << 20;

FileResult refuse(FileStatus status, std::string detail);
FileResult refuseTensor(FileStatus status, const std::string& name, const std::string& detail);

// Bytes that can be fetched piece by piece, so that a file is never in memory twice.
struct ByteSource {
  uint64_t size = 0;
  std::function<bool(uint64_t offset, void* to, size_t count)> read;
};
// The file stays open as long as the source lives. Refused with the system's reason: cannot_open, cannot_read.
FileResult openByteSource(const std::string& path, ByteSource* source);
// bytes   must outlive the source
ByteSource byteSource(std::string_view bytes);

// A tensor that only fills the space before the next one.
bool isPadding(std::string_view name);

// Bytes of one element: U8, U16, U32, U64, I8, I32, F16, F32, F64; 0 for any other dtype.
uint64_t dtypeBytes(std::string_view dtype);

// Where tensors may begin: at multiples of kLineBytes, as kernels read weights; or of the size of their own elements.
enum class TensorAlignment { line, element };
inline constexpr uint64_t kLineBytes = 64;

// Reads the header and checks it against the source: every tensor's dtype, its shape against its bytes, its alignment; that all
// tensors together cover the rest of the source without a hole, an overlap or a rest: the rule of safetensors itself; and the
// file's digest, where it names one: every byte is read once for it.
// dtype_fault   what is wrong with a tensor of this name and dtype; empty: nothing. It lets only dtypes pass that dtypeBytes knows.
// header        metadata without kDigestKey; digest_offset says whether it was there
// data_offset   where the tensors begin
// returns       ok, with kNoDigest as its detail where the file names none; otherwise what is wrong
FileResult readLayout(const ByteSource& source, TensorAlignment alignment,
                      std::string (*dtype_fault)(const std::string& name, const std::string& dtype), WeightsHeader* header,
                      uint64_t* data_offset);

// What is said of safetensors files that others wrote.
inline constexpr const char* kNoDigest = "it names no file_sha256: whether it is damaged was not checked";
// … and of files whose version says that they name one.
inline constexpr const char* kDigestMissing = "it names no file_sha256, as files of its version do: damaged, or changed by hand";

// Writes a header, one tensor after another. It begins with the digest's key, whose digits stampDigest fills when the file's bytes
// are all there.
class HeaderWriter {
 public:
  // metadata   without kDigestKey
  HeaderWriter(const std::map<std::string, std::string>& metadata, TensorAlignment alignment);

  // returns   how many bytes of padding stand before the tensor's own
  uint64_t add(const std::string& name, const char* dtype, const std::vector<uint64_t>& shape, uint64_t bytes);

  // The header's text, which ends where tensors may begin.
  std::string finish();

 private:
  void addEntry(const std::string& name, const char* dtype, const std::vector<uint64_t>& shape, uint64_t bytes);

  TensorAlignment alignment_;
  std::string text_;
  uint64_t offset_ = 0, padding_count_ = 0;
};

// A header's text with its length before it: how a file begins.
std::string withLength(const std::string& header);

// Fills in the digest of a whole file whose header a HeaderWriter wrote.
void stampDigest(std::string* file);

}  // namespace nlg
