#include "tool/input_file.h"

#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "runtime_eval/regular_file/regular_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

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

}  // namespace

void noteInput(const std::string& path) {
  const std::lock_guard lock(inputs().mutex);
  inputs().paths.insert(path);
}

std::vector<std::string> inputsSoFar() {
  const std::lock_guard lock(inputs().mutex);
  return {inputs().paths.begin(), inputs().paths.end()};
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

}  // namespace nlg
