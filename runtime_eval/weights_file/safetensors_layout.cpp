#include "runtime_eval/weights_file/safetensors_layout.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "runtime_eval/regular_file/regular_file.h"
#include "runtime_eval/weights_file/sha256.h"

static_assert(std::endian::native == std::endian::little, "lengths and tensors are copied as they lie in the file");

namespace nlg {
namespace {

constexpr uint64_t kLengthBytes = 8;
constexpr std::string_view kPaddingPrefix = "padding.";
constexpr std::string_view kHeaderStart = "{\"__metadata__\":{\"file_sha256\":\"";
constexpr size_t kDigestDigits = 2 * sizeof(Sha256Digest);
constexpr size_t kReadBlockBytes = size_t{1} << 20;

struct OpenFile {
  int descriptor = -1;
  OpenFile() = default;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor >= 0) closeRegularFile(descriptor);
  }
};

uint64_t missingTo(uint64_t alignment, uint64_t bytes) { return (alignment - bytes % alignment) % alignment; }
uint64_t alignmentOf(TensorAlignment alignment, std::string_view dtype) {
  return alignment == TensorAlignment::line ? kLineBytes : std::max<uint64_t>(1, dtypeBytes(dtype));
}

// Bytes of a tensor; false when they exceed 64 bits.
bool tensorBytes(const std::vector<uint64_t>& shape, uint64_t element_bytes, uint64_t* bytes) {
  *bytes = element_bytes;
  for (const uint64_t count : shape) {
    if (count != 0 && *bytes > std::numeric_limits<uint64_t>::max() / count) return false;
    *bytes *= count;
  }
  return true;
}

FileResult readHeader(const ByteSource& source, WeightsHeader* header, uint64_t* data_offset) {
  uint64_t length = 0;
  if (source.size < kLengthBytes) return refuse(FileStatus::too_short, "shorter than the 8 bytes of the header's length");
  if (!source.read(0, &length, kLengthBytes)) return refuse(FileStatus::cannot_read, "header length");
  if (length > kMaxHeaderBytes || length > source.size - kLengthBytes) {
    return refuse(FileStatus::header_too_large,
                  "header of " + std::to_string(length) + " bytes in a file of " + std::to_string(source.size));
  }
  std::string text(length, '\0');
  if (!source.read(kLengthBytes, text.data(), length)) return refuse(FileStatus::cannot_read, "header");
  const std::string fault = parseWeightsHeader(text, header);
  if (!fault.empty()) return refuse(FileStatus::header_malformed, "header, " + fault);
  *data_offset = kLengthBytes + length;
  return {};
}

// One tensor by itself: alignment in the file, and a shape that fills its range exactly.
FileResult checkTensor(const std::string& name, const TensorEntry& tensor, TensorAlignment alignment, uint64_t data_offset) {
  constexpr FileStatus kMalformed = FileStatus::tensor_malformed;
  uint64_t bytes = 0;
  if (!tensorBytes(tensor.shape, dtypeBytes(tensor.dtype), &bytes)) return refuseTensor(kMalformed, name, "shape too large");
  if (tensor.begin > tensor.end || tensor.end - tensor.begin != bytes) {
    return refuseTensor(kMalformed, name, "shape and data_offsets disagree");
  }
  // offsets beyond the file are refused later; here they must not wrap around
  const uint64_t multiple = alignmentOf(alignment, tensor.dtype);
  const bool is_aligned = (data_offset % multiple + tensor.begin % multiple) % multiple == 0;
  if (!isPadding(name) && !is_aligned)
    return refuseTensor(kMalformed, name, "does not start at a multiple of " + std::to_string(multiple) + " bytes");
  return {};
}

FileResult checkCoverage(const WeightsHeader& header, uint64_t data_bytes) {
  std::vector<std::pair<std::string_view, const TensorEntry*>> in_order;
  for (const auto& [name, tensor] : header.tensors) in_order.emplace_back(name, &tensor);
  std::sort(in_order.begin(), in_order.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second->begin, a.second->end) < std::pair(b.second->begin, b.second->end);
  });
  // in their order tensors must tile the data: no overlap, no hole, no rest
  uint64_t covered = 0;
  for (const auto& [name, tensor] : in_order) {
    if (tensor->begin != covered) {
      const std::string what = tensor->begin < covered ? "overlaps" : "leaves a hole behind";
      return refuseTensor(FileStatus::tensor_malformed, std::string(name), what + " the tensor before it");
    }
    covered = tensor->end;
  }
  if (covered > data_bytes) {
    return refuse(FileStatus::too_short,
                  "tensors of " + std::to_string(covered) + " bytes, " + std::to_string(data_bytes) + " are there");
  }
  if (covered < data_bytes) return refuse(FileStatus::tensor_malformed, "bytes behind the last tensor");
  return {};
}

// Digests bytes with the digits of the digest itself taken as zeros.
class FileDigest {
 public:
  // digest_offset   in the file
  explicit FileDigest(uint64_t digest_offset) : digest_offset_(digest_offset) {}

  // The file's bytes in their order.
  void add(const char* bytes, size_t count) {
    const auto within = [&](uint64_t offset) {
      return static_cast<size_t>(std::clamp<uint64_t>(offset, position_, position_ + count) - position_);
    };
    const size_t first = within(digest_offset_), last = within(digest_offset_ + kDigestDigits);
    const std::string zeros(last - first, '0');
    hash_.add(bytes, first);
    hash_.add(zeros.data(), zeros.size());
    hash_.add(bytes + last, count - last);
    position_ += count;
  }
  std::string finish() { return hexadecimal(hash_.finish()); }

 private:
  uint64_t digest_offset_, position_ = 0;
  Sha256 hash_;
};

// Takes the digest out of the metadata and compares it with the source's bytes.
FileResult checkDigest(const ByteSource& source, WeightsHeader* header) {
  const auto found = header->metadata.find(kDigestKey);
  if (found == header->metadata.end()) return {FileStatus::ok, kNoDigest};
  const std::string named = std::move(found->second);
  header->metadata.erase(found);
  FileDigest digest(kLengthBytes + header->digest_offset);
  std::vector<char> block(std::min<uint64_t>(source.size, kReadBlockBytes));
  for (uint64_t at = 0; at < source.size; at += block.size()) {
    const size_t count = std::min<uint64_t>(block.size(), source.size - at);
    if (!source.read(at, block.data(), count)) return refuse(FileStatus::cannot_read, "byte " + std::to_string(at));
    digest.add(block.data(), count);
  }
  if (digest.finish() == named) return {};
  return refuse(FileStatus::digest_mismatch,
                "its bytes do not match its file_sha256: the file is damaged, or was changed by hand");
}

}  // namespace

FileResult refuse(FileStatus status, std::string detail) { return {status, std::move(detail)}; }

FileResult refuseTensor(FileStatus status, const std::string& name, const std::string& detail) {
  return {status, "tensor " + jsonQuoted(name) + ": " + detail};
}

FileResult openByteSource(const std::string& path, ByteSource* source) {
  std::string fault;
  const auto file = std::make_shared<OpenFile>();
  file->descriptor = openRegularFile(path, &fault);
  if (file->descriptor < 0) return refuse(FileStatus::cannot_open, fault);
  const int64_t size = regularFileSize(file->descriptor);
  if (size < 0) return refuse(FileStatus::cannot_read, std::strerror(errno));
  *source = {static_cast<uint64_t>(size),
             [file](uint64_t offset, void* to, size_t count) { return readRegularFile(file->descriptor, offset, to, count); }};
  return {};
}

ByteSource byteSource(std::string_view bytes) {
  return {bytes.size(), [bytes](uint64_t offset, void* to, size_t count) {
            std::memcpy(to, bytes.data() + offset, count);
            return true;
          }};
}

bool isPadding(std::string_view name) { return name.substr(0, kPaddingPrefix.size()) == kPaddingPrefix; }

uint64_t dtypeBytes(std::string_view dtype) {
  constexpr std::pair<std::string_view, uint64_t> kTypes[] = {{"U8", 1},  {"U16", 2}, {"U32", 4}, {"U64", 8}, {"I8", 1},
                                                              {"I32", 4}, {"F16", 2}, {"F32", 4}, {"F64", 8}};
  for (const auto& [name, bytes] : kTypes) {
    if (name == dtype) return bytes;
  }
  return 0;
}

FileResult readLayout(const ByteSource& source, TensorAlignment alignment,
                      std::string (*dtype_fault)(const std::string& name, const std::string& dtype), WeightsHeader* header,
                      uint64_t* data_offset) {
  FileResult result = readHeader(source, header, data_offset);
  if (!result.ok()) return result;
  // each tensor by itself, then all of them against the file's size, then every byte against the digest
  for (const auto& [name, tensor] : header->tensors) {
    const std::string fault = dtype_fault(name, tensor.dtype);
    if (!fault.empty()) return refuseTensor(FileStatus::tensor_malformed, name, fault);
    result = checkTensor(name, tensor, alignment, *data_offset);
    if (!result.ok()) return result;
  }
  result = checkCoverage(*header, source.size - *data_offset);
  return result.ok() ? checkDigest(source, header) : result;
}

HeaderWriter::HeaderWriter(const std::map<std::string, std::string>& metadata, TensorAlignment alignment)
    : alignment_(alignment), text_(kHeaderStart) {
  text_.append(kDigestDigits, '0') += '"';
  for (const auto& [key, value] : metadata) text_ += "," + jsonQuoted(key) + ":" + jsonQuoted(value);
  text_ += '}';
}

uint64_t HeaderWriter::add(const std::string& name, const char* dtype, const std::vector<uint64_t>& shape, uint64_t bytes) {
  const uint64_t padding = missingTo(alignmentOf(alignment_, dtype), offset_);
  if (padding > 0) addEntry(std::string(kPaddingPrefix) + std::to_string(padding_count_++), "U8", {padding}, padding);
  addEntry(name, dtype, shape, bytes);
  return padding;
}

void HeaderWriter::addEntry(const std::string& name, const char* dtype, const std::vector<uint64_t>& shape, uint64_t bytes) {
  text_ += "," + jsonQuoted(name) + ":{\"dtype\":\"" + dtype + "\",\"shape\":[";
  for (size_t i = 0; i < shape.size(); ++i) text_ += (i > 0 ? "," : "") + std::to_string(shape[i]);
  text_ += "],\"data_offsets\":[" + std::to_string(offset_) + "," + std::to_string(offset_ + bytes) + "]}";
  offset_ += bytes;
}

std::string HeaderWriter::finish() {
  text_ += "}";
  text_.append(missingTo(kLineBytes, kLengthBytes + text_.size()), ' ');
  return text_;
}

std::string withLength(const std::string& header) {
  const uint64_t length = header.size();
  return std::string(reinterpret_cast<const char*>(&length), kLengthBytes) + header;
}

void stampDigest(std::string* file) {
  constexpr size_t kDigestOffset = kLengthBytes + kHeaderStart.size();
  FileDigest digest(kDigestOffset);
  digest.add(file->data(), file->size());
  file->replace(kDigestOffset, kDigestDigits, digest.finish());
}

}  // namespace nlg
