// A set of .pk3 archives (ZIP), mounted over each other as in Quake III-family games.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scene/archive/scene_file.h"

namespace nlg {

// Names are compared without regard to case and are given back in lower case. Nothing is ever extracted to the disk.
class Pk3Archives {
 public:
  // path     a .pk3 file, or a folder: all its .pk3 files (not those of its subfolders) in alphabetical order; a file of a later
  //          archive hides that of an earlier one
  // throws   InputError on: no such file, a folder without archives, what is no ZIP archive or is cut short, ZIP64 or more than
  //          4 GiB, more than 2^16 entries, entry names that are absolute, hold "..", a backslash, a colon or a control
  //          character, a folder's entry that holds data
  // unpacked   budget for all that is read; null: one of its own, whole
  explicit Pk3Archives(const std::string& path, SceneBudget* unpacked = nullptr);
  ~Pk3Archives();
  Pk3Archives(const Pk3Archives&) = delete;
  Pk3Archives& operator=(const Pk3Archives&) = delete;

  const std::string& path() const { return path_; }
  bool has(const std::string& name) const;
  // Names that begin and end so, in alphabetical order.
  std::vector<std::string> names(std::string_view prefix, std::string_view suffix) const;
  // Number of the archive that holds the visible file of that name; later ones have larger numbers. The name must be there.
  size_t archiveIndex(const std::string& name) const;
  // Bytes of the file as its archive declares them.
  // throws   InputError naming archive and entry on a name that is not there
  uint64_t sizeOf(const std::string& name) const;
  // The file's bytes; its checksum has been compared.
  //
  // throws   InputError naming archive and entry on: a name that is not there, an entry that is encrypted, neither stored nor
  //          deflated, larger than max_bytes, of another size than it declares, damaged; on more bytes than the budget holds
  std::string read(const std::string& name, size_t max_bytes) const;

 private:
  struct Archive;
  struct Entry {
    size_t archive_idx = 0;
    uint64_t entry_idx = 0;
  };

  void mount(const std::string& file);
  const Entry& entryOf(const std::string& name) const;

  std::string path_;
  mutable SceneBudget own_budget_ = SceneBudgets().unpacked;
  SceneBudget* const unpacked_;
  std::vector<std::unique_ptr<Archive>> archives_;
  std::map<std::string, Entry> entries_;  // by name in lower case
};

// ASCII letters in lower case; all else stays.
std::string lowerCase(std::string_view text);

// What a path ends in, in lower case: ".pk3".
std::string extensionOf(const std::string& path);

// The path itself, if it is no folder; otherwise all of its files with this extension, in alphabetical order without regard to case.
// throws   InputError on a folder that cannot be read or has none
std::vector<std::string> archiveFiles(const std::string& path, const std::string& extension);

}  // namespace nlg
