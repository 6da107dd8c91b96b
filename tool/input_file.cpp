#include "tool/input_file.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string_view>

#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "runtime_eval/regular_file/regular_file.h"
#include "runtime_eval/weights_file/safetensors_layout.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kHeaderBegins = 8;  // of a safetensors file, behind its length
constexpr char kBytes = 1;           // what the name of a file that is no text begins with

std::string reason() { return std::generic_category().message(errno); }

// Calls readSome(to, count) until the bytes are there, or the file's end.
template <class ReadSome>
size_t readAll(const std::string& path, const std::string& place, char* to, size_t count, const ReadSome& readSome) {
  size_t done = 0;
  while (done < count) {
    const ssize_t more = readSome(to + done, count - done);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) throw InputError(path, place, "a readable file", reason());
    if (more == 0) break;
    done += static_cast<size_t>(more);
  }
  return done;
}

struct Inputs {
  std::mutex mutex;
  std::set<std::string> paths;
};

Inputs& inputs() {
  static Inputs all;
  return all;
}

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
  // two things that one damaged byte does not bring about: a header of impossible length that does not begin as JSON
  std::string head(kHeaderBegins + 1, '\0');
  uint64_t header_bytes = 0;
  if (source.size < head.size() || !source.read(0, head.data(), head.size())) return "";
  std::memcpy(&header_bytes, head.data(), sizeof header_bytes);
  if (header_bytes > source.size && head[kHeaderBegins] != '{') return "a file of another kind, not safetensors";
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

void noteInput(const std::string& path) {
  const std::lock_guard lock(inputs().mutex);
  inputs().paths.insert(path);
}

std::vector<std::string> inputsSoFar() {
  const std::lock_guard lock(inputs().mutex);
  return {inputs().paths.begin(), inputs().paths.end()};
}

std::string inputsText(const std::vector<std::string>& paths) {
  nlohmann::json names = nlohmann::json::array();
  for (const std::string& path : paths) {
    const bool is_text = path[0] != kBytes && nlohmann::json::parse(nlohmann::json(path).dump(
                                                  -1, ' ', false, nlohmann::json::error_handler_t::ignore)) == path;
    std::string bytes(1, kBytes);
    for (const unsigned char byte : path) {
      if (byte >= 0x80) bytes += static_cast<char>(0xc0 | byte >> 6);
      bytes += static_cast<char>(byte < 0x80 ? byte : 0x80 | (byte & 0x3f));
    }
    names.push_back(is_text ? path : bytes);
  }
  std::sort(names.begin(), names.end());
  return names.dump() + "\n";
}

std::vector<std::string> inputsOf(const std::string& text) {
  auto paths = nlohmann::json::parse(text).get<std::vector<std::string>>();
  for (std::string& path : paths) {
    if (path[0] != kBytes) continue;
    std::string bytes;
    for (size_t at = 1; at < path.size(); ++at) {
      const auto byte = static_cast<unsigned char>(path[at]);
      bytes += byte < 0x80 ? path[at] : static_cast<char>((byte & 3) << 6 | (path[++at] & 0x3f));
    }
    path = bytes;
  }
  return paths;
}

InputError notOpened(const std::string& path, const std::string& place, const std::string& fault) {
  const bool is_missing = fault == std::generic_category().message(ENOENT);
  return {path, place, is_missing ? "a file" : "a regular file", is_missing ? kNoSuchFile : fault};
}

InputFile::InputFile(const std::string& path, std::string place) : path_(path), place_(std::move(place)) {
  noteInput(path);
  std::string fault;
  descriptor_ = openRegularFile(path, &fault);
  if (descriptor_ < 0) throw notOpened(path, place_, fault);
  struct stat status {};
  if (::fstat(descriptor_, &status) == 0) size_ = static_cast<uint64_t>(status.st_size);
}

InputFile::~InputFile() { ::close(descriptor_); }

size_t InputFile::read(void* to, size_t count) {
  return readAll(path_, place_, static_cast<char*>(to), count,
                 [this](char* at, size_t left) { return ::read(descriptor_, at, left); });
}

size_t InputFile::readAt(uint64_t offset, void* to, size_t count) const {
  char* const begin = static_cast<char*>(to);
  return readAll(path_, place_, begin, count, [&](char* at, size_t left) {
    return ::pread(descriptor_, at, left, static_cast<off_t>(offset + static_cast<uint64_t>(at - begin)));
  });
}

OneFileEach::OneFileEach(std::string flag, std::string kind) : flag_(std::move(flag)), kind_(std::move(kind)) {}

void OneFileEach::add(const std::string& path, const std::string& what) {
  const auto [earlier, is_new] = path_of_.emplace(what, path);
  if (!is_new) throw UsageError(flag_, "one file per " + kind_, "two of " + what + ": " + earlier->second + " and " + path);
}

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
    if (isDamage(result.status)) throw InputError(path, "file", expected, kind);
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
