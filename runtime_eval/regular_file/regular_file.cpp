#include "runtime_eval/regular_file/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace nlg {
namespace {

std::string reasonOf(int error_number) { return std::generic_category().message(error_number); }

// What a file that is no regular one is called.
const char* kindOf(mode_t mode) {
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  return "something else";
}

}  // namespace

int openRegularFile(const std::string& path, std::string* fault) {
  // a pipe without a writer would keep open() waiting, and a terminal would become ours
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  struct stat status {};
  if (file < 0) {
    // of a socket, and of a device without a driver, the system says no more than that it cannot be opened
    const int reason = errno;
    const bool is_known = reason == ENXIO && ::stat(path.c_str(), &status) == 0;
    *fault = is_known ? kindOf(status.st_mode) : reasonOf(reason);
    return -1;
  }
  if (::fstat(file, &status) != 0) {
    *fault = reasonOf(errno);
  } else if (!S_ISREG(status.st_mode)) {
    *fault = kindOf(status.st_mode);
  } else if (::fcntl(file, F_SETFL, O_RDONLY) != 0) {
    // some network file systems would hand a reader that does not wait half of what it asks for
    *fault = reasonOf(errno);
  } else {
    return file;
  }
  ::close(file);
  return -1;
}

void closeRegularFile(int file) { ::close(file); }

int64_t regularFileSize(int file) {
  struct stat status {};
  return ::fstat(file, &status) == 0 ? status.st_size : -1;
}

bool readRegularFile(int file, uint64_t offset, void* to, size_t count) {
  char* at = static_cast<char*>(to);
  while (count > 0) {
    const ssize_t more = ::pread(file, at, count, static_cast<off_t>(offset));
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) return false;
    at += more;
    offset += static_cast<uint64_t>(more);
    count -= static_cast<size_t>(more);
  }
  return true;
}

}  // namespace nlg
