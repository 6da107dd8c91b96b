#include "viewer/watched_files.h"

#include <sys/stat.h>

#include <algorithm>

namespace nlg {

// By when it came to be what it is here (ctime): a copy may keep the time of what it was made of.
WatchedFiles::Stamp WatchedFiles::stampOf(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino, static_cast<uint64_t>(status.st_size),
          int64_t{status.st_ctim.tv_sec} * 1'000'000'000 + status.st_ctim.tv_nsec};
}

void WatchedFiles::watch(const std::vector<std::string>& paths, int64_t since_ns) {
  std::map<std::string, Stamp> stamps;
  for (const std::string& path : paths) {
    const auto known = stamps_.find(path);
    Stamp stamp = known != stamps_.end() ? known->second : stampOf(path);
    if (known == stamps_.end() && stamp.written_ns > since_ns) stamp = {};
    stamps[path] = stamp;
  }
  stamps_ = std::move(stamps);
}

bool WatchedFiles::haveChanged() const {
  return std::any_of(stamps_.begin(), stamps_.end(), [](const auto& one) { return stampOf(one.first) != one.second; });
}

void WatchedFiles::accept() {
  for (auto& [path, stamp] : stamps_) stamp = stampOf(path);
}

}  // namespace nlg
