// Shared parts of reading and writing HDF5. Internal to this folder: others include hdf5_file.h.
#pragma once

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "tool/error.h"

namespace nlg::hdf5 {

inline constexpr uint64_t kMaxArrayBytes = uint64_t{1} << 38;
inline constexpr uint64_t kMaxTextBytes = uint64_t{16} << 20;
inline constexpr int kMaxDimensions = 4;
inline constexpr const char* kDigestName = "file_sha256";
inline constexpr uint64_t kDigestBytes = 32;

// An HDF5 identifier that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  bool ok() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// Every public function starts here: HDF5 keeps its error stack, and whether to print it, per thread.
inline void silenceHdf5() {
  // after a full disk, HDF5's own handler at exit writes once more to what is gone, and crashes; we close everything ourselves
  static const herr_t no_exit_handler = H5dont_atexit();
  static_cast<void>(no_exit_handler);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

// HDF5 1.10 ends the process by a signal when it is refused the memory of a file's cache: the system is asked for it before.
// throws   std::bad_alloc
inline void requireMemoryOfAFile() {
  constexpr size_t kFileBytes = size_t{4} << 20;
  // Twice: the first block is a mapping of its own. Once it has been given back, glibc takes blocks of its size from the heap, and keeps
  // them there, so that HDF5 gets what the second one was.
  for (int time = 0; time < 2; ++time) {
    void* const memory = std::malloc(kFileBytes);
    if (memory == nullptr) throw std::bad_alloc();
    // a use, or the compiler would ask for nothing
    *static_cast<volatile char*>(memory) = 0;
    std::free(memory);
  }
}

// What HDF5 says at the place where the error arose; when the system refused, only the system's words (the rest holds a time).
inline std::string innermostError() {
  std::string text = "an unknown HDF5 error";
  const auto takeFirst = [](unsigned depth, const H5E_error2_t* error, void* data) -> herr_t {
    if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(data) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, takeFirst, &text);
  const std::string mark = "error message = '";
  const size_t begin = text.find(mark);
  if (begin == std::string::npos) return text;
  text = text.substr(begin + mark.size());
  text = text.substr(0, text.find('\''));
  return text.find("No space left") == std::string::npos ? text : text + " (the disk is full)";
}

// An element's type as it lies in the file, on any machine, and as this machine holds it.
struct ElementType {
  hid_t file, memory;
};
inline ElementType elementType(uint8_t) { return {H5T_STD_U8LE, H5T_NATIVE_UINT8}; }
inline ElementType elementType(uint32_t) { return {H5T_STD_U32LE, H5T_NATIVE_UINT32}; }
inline ElementType elementType(int32_t) { return {H5T_STD_I32LE, H5T_NATIVE_INT32}; }
inline ElementType elementType(uint64_t) { return {H5T_STD_U64LE, H5T_NATIVE_UINT64}; }
inline ElementType elementType(float) { return {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT}; }
inline ElementType elementType(double) { return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE}; }

// Bytes of an array; false when they exceed what we ever handle.
inline bool arrayBytes(const std::vector<uint64_t>& shape, uint64_t element_bytes, uint64_t* bytes) {
  *bytes = element_bytes;
  // an empty array is empty whatever its other dimensions say
  if (std::find(shape.begin(), shape.end(), 0u) != shape.end()) *bytes = 0;
  for (const uint64_t count : shape) {
    if (__builtin_mul_overflow(*bytes, count, bytes) || *bytes > kMaxArrayBytes) return false;
  }
  return true;
}

inline std::string shapeText(const std::vector<uint64_t>& shape) { return fmt::format("{}", fmt::join(shape, " x ")); }

}  // namespace nlg::hdf5
