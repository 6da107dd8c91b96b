// Watches files for changes.
//
// They are asked after, not listened to: what the kernel tells of a file (inotify) it does not tell of shared and network folders, and
// programs that save by renaming put another file in its place. Asking after some hundred files takes a millisecond.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace nlg {

class WatchedFiles {
 public:
  // Takes these files in place of the ones before, as they are now; of those that were watched already what is known of them stays.
  // since_ns   a new one that was written after this time counts as changed
  void watch(const std::vector<std::string>& paths, int64_t since_ns);

  // Whether any of them is another one than before, or has come or gone.
  bool haveChanged() const;
  // From here on they are what they are now.
  void accept();

 private:
  struct Stamp {
    uint64_t device = 0, file = 0, bytes = 0;
    int64_t written_ns = -1;  // there is none
    bool operator==(const Stamp&) const = default;
  };
  static Stamp stampOf(const std::string& path);

  std::map<std::string, Stamp> stamps_;
};

}  // namespace nlg
