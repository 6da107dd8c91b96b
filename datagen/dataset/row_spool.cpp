#include "datagen/dataset/row_spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "tool/error.h"

namespace nlg {
namespace {

[[noreturn]] void fail(const std::string& folder, int error_number) {
  throw OutputError(folder + "/(samples of functions, for comparison)", std::generic_category().message(error_number));
}

}  // namespace

std::string temporaryFolder() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (!error) return folder;
  const char* name = std::getenv("TMPDIR");
  throw OutputError(name == nullptr ? "/tmp" : name, error.message() + " (TMPDIR, the folder for temporary files)");
}

RowSpool::RowSpool(const std::string& folder, int point_count)
    : folder_(folder), point_count_(static_cast<size_t>(point_count)), row_(point_count_ + point_count_ / 8) {
  file_ = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file_ >= 0) return;
  // file systems that know no files without names: make one and take its name away
  std::string name = folder + "/.rows.XXXXXX";
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail(folder_, errno);
  ::unlink(name.c_str());
}

RowSpool::~RowSpool() { ::close(file_); }

void RowSpool::append(const StoredFunction& function) {
  std::copy_n(function.phi, point_count_, row_.begin());
  std::copy_n(function.validity, point_count_ / 8, row_.begin() + static_cast<ptrdiff_t>(point_count_));
  for (size_t done = 0; done < row_.size();) {
    const auto offset = static_cast<off_t>(count_ * row_.size() + done);
    const ssize_t written = ::pwrite(file_, row_.data() + done, row_.size() - done, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(folder_, written < 0 ? errno : ENOSPC);
    done += static_cast<size_t>(written);
  }
  ++count_;
}

StoredFunction RowSpool::read(uint64_t n) {
  NLG_CHECK(n, <, count_);
  for (size_t done = 0; done < row_.size();) {
    const auto offset = static_cast<off_t>(n * row_.size() + done);
    const ssize_t got = ::pread(file_, row_.data() + done, row_.size() - done, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(folder_, got < 0 ? errno : EIO);
    done += static_cast<size_t>(got);
  }
  return {row_.data(), row_.data() + point_count_};
}

}  // namespace nlg
