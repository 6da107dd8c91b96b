#include "datagen/dataset/nameless_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "tool/error.h"

namespace nlg {

std::string temporaryFolder() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (!error) return folder;
  const char* name = std::getenv("TMPDIR");
  throw OutputError(name == nullptr ? "/tmp" : name, error.message() + " (TMPDIR, the folder for temporary files)");
}

NamelessFile::NamelessFile(const std::string& folder, const std::string& purpose) : place_(folder + "/(" + purpose + ")") {
  file_ = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file_ >= 0) return;
  // file systems that know no files without names: make one and take its name away
  std::string name = folder + "/.nlg.XXXXXX";
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail(errno);
  ::unlink(name.c_str());
}

NamelessFile::~NamelessFile() { ::close(file_); }

void NamelessFile::fail(int error_number) const { throw OutputError(place_, std::generic_category().message(error_number)); }

void NamelessFile::append(const void* bytes, size_t count) {
  for (size_t done = 0; done < count;) {
    const ssize_t written =
        ::pwrite(file_, static_cast<const char*>(bytes) + done, count - done, static_cast<off_t>(byte_count_ + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(written < 0 ? errno : ENOSPC);
    done += static_cast<size_t>(written);
  }
  byte_count_ += count;
}

void NamelessFile::read(uint64_t first, void* bytes, size_t count) const {
  NLG_CHECK(first + count, <=, byte_count_);
  for (size_t done = 0; done < count;) {
    const ssize_t got = ::pread(file_, static_cast<char*>(bytes) + done, count - done, static_cast<off_t>(first + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(got < 0 ? errno : EIO);
    done += static_cast<size_t>(got);
  }
}

}  // namespace nlg
