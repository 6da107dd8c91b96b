#include "datagen/functions/nameless_file.h"

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "datagen/functions/chunk_codec.h"
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

PackedFunctions::PackedFunctions(int point_count, const std::string& folder)
    : point_count_(static_cast<size_t>(point_count)),
      file_(folder, "samples of functions, for comparison"),
      samples_(point_count_ / 8 * 9) {}

uint64_t PackedFunctions::append(const StoredFunction& function) {
  std::copy_n(function.phi, point_count_, samples_.begin());
  std::copy_n(function.validity, point_count_ / 8, samples_.begin() + static_cast<ptrdiff_t>(point_count_));
  packed_ = encodeChunk(samples_.data(), samples_.size());
  const uint64_t place = file_.byteCount();
  const auto byte_count = static_cast<uint32_t>(packed_.size());
  file_.append(&byte_count, sizeof byte_count);
  file_.append(packed_.data(), packed_.size());
  return place;
}

StoredFunction PackedFunctions::at(uint64_t place) {
  uint32_t byte_count = 0;
  file_.read(place, &byte_count, sizeof byte_count);
  packed_.resize(byte_count);
  file_.read(place + sizeof byte_count, packed_.data(), packed_.size());
  NLG_CHECK(decodeChunk(packed_.data(), packed_.size(), samples_.data(), samples_.size()), ==, true);
  return {samples_.data(), samples_.data() + point_count_};
}

RowSpool::RowSpool(const std::string& folder, int point_count)
    : file_(folder, "samples of functions, for comparison"),
      point_count_(static_cast<size_t>(point_count)),
      row_(2 * point_count_ + point_count_ / 8) {}

void RowSpool::append(const StoredFunction& function) {
  std::copy_n(function.phi, point_count_, row_.begin());
  std::copy_n(function.validity, point_count_ / 8, row_.begin() + static_cast<ptrdiff_t>(point_count_));
  const auto sums = row_.begin() + static_cast<ptrdiff_t>(point_count_ + point_count_ / 8);
  if (function.blend_sum != nullptr) {
    std::copy_n(function.blend_sum, point_count_, sums);
  } else {
    std::fill(sums, row_.end(), uint8_t{255});
  }
  file_.append(row_.data(), row_.size());
}

StoredFunction RowSpool::read(uint64_t n, std::vector<uint8_t>* samples) const {
  samples->resize(row_.size());
  file_.read(n * row_.size(), samples->data(), samples->size());
  return {samples->data(), samples->data() + point_count_, nullptr, samples->data() + point_count_ + point_count_ / 8};
}

}  // namespace nlg
