#include "tool/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <system_error>

#include "runtime_eval/weights_file/sha256.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

constexpr size_t kReadBlockBytes = size_t{1} << 20;

// The system's words; a full disk is the one reason that everybody meets, so it is spelled out.
std::string reasonOf(int error_number) {
  const std::string words = std::generic_category().message(error_number);
  if (error_number == ENOSPC) return words + " (the disk is full: free some space or write elsewhere)";
  if (error_number == EDQUOT) return words + " (the user's share of the disk is full)";
  return words;
}

class FileDescriptor {
 public:
  FileDescriptor(const std::string& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~FileDescriptor() { close(); }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  bool isOpen() const { return fd_ >= 0; }
  int get() const { return fd_; }

  // network file systems report a full disk no earlier than here
  bool close() {
    const int fd = fd_;
    fd_ = -1;
    return fd < 0 || ::close(fd) == 0;
  }

 private:
  int fd_;
};

std::string hostName() {
  char name[256] = {};
  if (::gethostname(name, sizeof name - 1) != 0 || name[0] == '\0') return "host";
  std::string text = name;
  std::replace(text.begin(), text.end(), '/', '_');
  return text;
}

// Everything that this machine's processes write for path begins so: a process id means something on its own machine only.
std::string temporaryPrefixFor(const std::string& path) { return path + ".tmp." + hostName() + "."; }

// A path beside the final one: rename is atomic only inside one file system.
std::string temporaryPathFor(const std::string& path) {
  static std::atomic<uint64_t> counter{0};
  return temporaryPrefixFor(path) + std::to_string(::getpid()) + "." + std::to_string(counter++);
}

std::string folderOf(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? "." : folder.string();
}

void makeFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(folderOf(path), error);
  if (error) throw OutputError(path, "folder " + folderOf(path) + ": " + reasonOf(error.value()));
}

// Removes what processes of this machine that are gone left behind for path. Whatever cannot be removed stays: it harms nobody.
void removeStaleTemporaries(const std::string& path) {
  const std::string prefix = std::filesystem::path(temporaryPrefixFor(path)).filename().string();
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folderOf(path), error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.rfind(prefix, 0) != 0) continue;
    const char* const first = name.c_str() + prefix.size();
    char* last = nullptr;
    const long process = std::strtol(first, &last, 10);
    if (last == first || *last != '.' || process <= 0) continue;
    if (::kill(static_cast<pid_t>(process), 0) == 0 || errno != ESRCH) continue;
    std::error_code ignored;
    std::filesystem::remove(entry->path(), ignored);
  }
}

void syncFile(const std::string& temporary_path, const std::string& path) {
  FileDescriptor file(temporary_path, O_RDONLY);
  if (!file.isOpen() || ::fsync(file.get()) != 0 || !file.close()) throw OutputError(path, reasonOf(errno));
}

// Without this the rename itself may be lost in a power cut.
void syncFolder(const std::string& path) {
  FileDescriptor folder(folderOf(path), O_RDONLY | O_DIRECTORY);
  // a folder that may be written but not read, or a file system that cannot flush folders: the rename stands all the same
  if (!folder.isOpen()) return;
  if (::fsync(folder.get()) != 0 && errno != EINVAL && errno != ENOTSUP) throw OutputError(path, reasonOf(errno));
}

void writeAll(const std::string& temporary_path, const std::string& path, std::string_view bytes) {
  FileDescriptor file(temporary_path, O_WRONLY | O_CREAT | O_EXCL);
  if (!file.isOpen()) throw OutputError(path, reasonOf(errno));
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw OutputError(path, reasonOf(errno));
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  if (!file.close()) throw OutputError(path, reasonOf(errno));
}

// What a signal has to remove. A handler may neither lock nor allocate, so that the names lie in places of their own; a writer that
// finds none leaves a file behind at worst, which the next one removes.
struct Unfinished {
  std::atomic<bool> is_taken = false, is_there = false;
  char path[4096] = {};
};
std::array<Unfinished, 16> unfinished;

void removeUnfinished(int signal) {
  for (const Unfinished& file : unfinished) {
    if (file.is_there) ::unlink(file.path);
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

// Has a signal remove the file while this lives.
class RemovedOnSignals {
 public:
  explicit RemovedOnSignals(const std::string& path) {
    if (path.size() >= sizeof Unfinished::path) return;
    for (Unfinished& file : unfinished) {
      if (file.is_taken.exchange(true)) continue;
      path.copy(file.path, path.size());
      file.path[path.size()] = '\0';
      file.is_there = true;
      file_ = &file;
      return;
    }
  }
  ~RemovedOnSignals() {
    if (file_ == nullptr) return;
    file_->is_there = false;
    file_->is_taken = false;
  }
  RemovedOnSignals(const RemovedOnSignals&) = delete;
  RemovedOnSignals& operator=(const RemovedOnSignals&) = delete;

 private:
  Unfinished* file_ = nullptr;
};

// Calls take(block, size) for every block of the file.
template <class Take>
void forEachBlock(InputFile& file, Take take) {
  // a small file takes no more memory than it has bytes; one that says 0 may hold some all the same
  const size_t block_bytes = std::clamp<uint64_t>(file.size(), 4096, kReadBlockBytes);
  const auto block = std::make_unique<char[]>(block_bytes);
  while (const size_t count = file.read(block.get(), block_bytes)) take(block.get(), count);
}

// What HDF5, libtorch and our own writers say of the file that they were given, about the one that the user asked for.
[[noreturn]] void rethrowAbout(const std::string& path, const std::string& temporary_path, const std::exception& error) {
  std::string line = error.what();
  const size_t first = line.find(temporary_path);
  if (first == std::string::npos) throw;
  for (size_t at = first; at != std::string::npos; at = line.find(temporary_path, at + path.size())) {
    line.replace(at, temporary_path.size(), path);
  }
  throw OutputError(line);
}

}  // namespace

void writeAtomically(const std::string& path, const std::function<void(const std::string&)>& write) {
  makeFolder(path);
  // renaming over a device, a link or a folder would replace it
  std::error_code missing;
  const std::filesystem::file_status status = std::filesystem::symlink_status(path, missing);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw OutputError(path, std::filesystem::is_directory(status) ? "it is a directory" : "it exists and is not a regular file");
  }
  removeStaleTemporaries(path);
  const std::string temporary_path = temporaryPathFor(path);
  const RemovedOnSignals removed(temporary_path);
  try {
    write(temporary_path);
    // on the disk before it gets its name: a power cut leaves the old file or the whole new one
    syncFile(temporary_path, path);
    if (::rename(temporary_path.c_str(), path.c_str()) != 0) throw OutputError(path, reasonOf(errno));
  } catch (const std::exception& error) {
    ::unlink(temporary_path.c_str());
    rethrowAbout(path, temporary_path, error);
  } catch (...) {
    ::unlink(temporary_path.c_str());
    throw;
  }
  syncFolder(path);
}

void removeTemporariesOnSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // nohup's child, say, is not to end
    if (std::signal(signal, removeUnfinished) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

void writeFileAtomically(const std::string& path, std::string_view bytes) {
  writeAtomically(path, [&](const std::string& temporary_path) { writeAll(temporary_path, path, bytes); });
}

std::string readFile(const std::string& path, size_t max_bytes) {
  InputFile file(path);
  const auto requireAtMost = [&](uint64_t size) {
    if (size > max_bytes)
      throw InputError(path, "size", "at most " + std::to_string(max_bytes) + " bytes", std::to_string(size) + " or more");
  };
  requireAtMost(file.size());
  std::string bytes;
  // the size is a hint only: files may grow, and those of the system's own say 0
  bytes.reserve(file.size());
  forEachBlock(file, [&](const char* block, size_t count) {
    requireAtMost(bytes.size() + count);
    bytes.append(block, count);
  });
  return bytes;
}

std::string fileSha256(const std::string& path) {
  InputFile file(path);
  Sha256 hash;
  forEachBlock(file, [&](const char* block, size_t count) { hash.add(block, count); });
  return hexadecimal(hash.finish());
}

std::vector<uint8_t> fileSha256Bytes(const std::string& path, ByteRange zeroed) {
  InputFile file(path);
  Sha256 hash;
  uint64_t position = 0;
  forEachBlock(file, [&](char* block, size_t count) {
    const uint64_t first = std::clamp<uint64_t>(zeroed.first, position, position + count);
    const uint64_t last = std::clamp<uint64_t>(zeroed.first + zeroed.count, position, position + count);
    std::fill(block + (first - position), block + (std::max(first, last) - position), '\0');
    hash.add(block, count);
    position += count;
  });
  const Sha256Digest digest = hash.finish();
  return {digest.begin(), digest.end()};
}

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hexadecimal(hash.finish());
}

}  // namespace nlg
