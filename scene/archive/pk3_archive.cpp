#include "scene/archive/pk3_archive.h"

#include <fcntl.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <filesystem>

#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxArchiveBytes = (uint64_t{1} << 32) - 1;
constexpr uint64_t kMaxEntries = uint64_t{1} << 16;

std::string quoted(const std::string& text) {
  std::string shown;
  for (const char c : text.substr(0, 80)) shown += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return "\"" + shown + "\"";
}

// libzip believes the 64-bit counts of ZIP64 and reserves memory for them; no .pk3 needs them.
void refuseZip64(const std::string& file, const InputFile& archive) {
  const uint64_t size = archive.size();
  if (size > kMaxArchiveBytes) throw InputError(file, "archive", "less than 4 GiB", std::to_string(size) + " bytes");
  constexpr uint64_t kTail = 65536 + 64;  // the longest comment, and the records before it
  std::string tail(std::min(size, kTail), '\0');
  tail.resize(archive.readAt(size - tail.size(), tail.data(), tail.size()));
  if (tail.find("PK\x06\x07") != std::string::npos) throw InputError(file, "archive", "a plain ZIP archive", "ZIP64");
}

const char* nameProblem(const std::string& name) {
  if (name.empty()) return "an empty one";
  if (name[0] == '/') return "an absolute one";
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return "one with a control character";
    if (c == '\\' || c == ':') return "one with a backslash or a colon";
  }
  for (const fs::path& part : fs::path(name)) {
    if (part == "..") return "one that leaves the archive";
  }
  return nullptr;
}

struct CloseFile {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

}  // namespace

struct Pk3Archives::Archive {
  std::string file;
  zip_t* zip = nullptr;
  ~Archive() {
    if (zip != nullptr) zip_discard(zip);
  }
};

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string extensionOf(const std::string& path) { return lowerCase(fs::path(path).extension().string()); }

std::vector<std::string> archiveFiles(const std::string& path, const std::string& extension) {
  std::error_code error;
  noteInput(path);  // a folder may get another archive
  if (!fs::is_directory(path, error)) return {path};
  std::vector<std::string> files;
  for (fs::directory_iterator i(path, error), end; !error && i != end; i.increment(error)) {
    if (extensionOf(i->path().string()) == extension && i->is_regular_file(error)) files.push_back(i->path().string());
  }
  if (error) throw InputError(path, "folder", "a readable folder", error.message());
  if (files.empty()) throw InputError(path, "folder", extension + " files", "none");
  const auto key = [](const std::string& file) { return std::pair(lowerCase(fs::path(file).filename().string()), file); };
  std::sort(files.begin(), files.end(), [&](const std::string& a, const std::string& b) { return key(a) < key(b); });
  return files;
}

Pk3Archives::Pk3Archives(const std::string& path, SceneBudget* unpacked)
    : path_(path), unpacked_(unpacked != nullptr ? unpacked : &own_budget_) {
  for (const std::string& file : archiveFiles(path, ".pk3")) mount(file);
}

Pk3Archives::~Pk3Archives() = default;

void Pk3Archives::mount(const std::string& file) {
  const InputFile opened(file, "archive");
  refuseZip64(file, opened);
  int code = ZIP_ER_OPEN;
  auto archive = std::make_unique<Archive>();
  archive->file = file;
  // the file that was looked at, whatever stands at its path by now; the archive closes its own
  const int descriptor = ::fcntl(opened.descriptor(), F_DUPFD_CLOEXEC, 0);
  if (descriptor >= 0) archive->zip = zip_fdopen(descriptor, 0, &code);
  if (archive->zip == nullptr && descriptor >= 0) ::close(descriptor);
  if (archive->zip == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string words = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw InputError(file, "archive", "a whole ZIP archive", words);
  }
  const auto count = static_cast<uint64_t>(zip_get_num_entries(archive->zip, 0));
  if (count > kMaxEntries) throw InputError(file, "archive", "at most 65536 entries", std::to_string(count));
  for (uint64_t i = 0; i < count; ++i) {
    const std::string place = "entry " + std::to_string(i);
    zip_stat_t stat;
    const char* raw_name = zip_get_name(archive->zip, i, ZIP_FL_ENC_RAW);
    if (raw_name == nullptr || zip_stat_index(archive->zip, i, 0, &stat) != 0)
      throw InputError(file, place, "a name and a size", zip_strerror(archive->zip));
    const std::string name = raw_name;
    // a hostile name could lead out of the archive: it is refused, not cleaned
    if (const char* problem = nameProblem(name))
      throw InputError(file, place, "a name inside the archive", std::string(problem) + ": " + quoted(name));
    if (name.back() == '/') {
      if (stat.size != 0)
        throw InputError(file, place, "a folder without data", quoted(name) + " of " + std::to_string(stat.size) + " bytes");
      continue;
    }
    // the game ignores case, and of equal names takes that of the later archive
    entries_[lowerCase(name)] = {archives_.size(), i};
  }
  archives_.push_back(std::move(archive));
}

bool Pk3Archives::has(const std::string& name) const { return entries_.count(lowerCase(name)) > 0; }

std::vector<std::string> Pk3Archives::names(std::string_view prefix, std::string_view suffix) const {
  std::vector<std::string> found;
  for (auto i = entries_.lower_bound(std::string(prefix)); i != entries_.end() && i->first.starts_with(prefix); ++i) {
    if (i->first.ends_with(suffix) && i->first.size() >= prefix.size() + suffix.size()) found.push_back(i->first);
  }
  return found;
}

size_t Pk3Archives::archiveIndex(const std::string& name) const { return entries_.at(lowerCase(name)).archive_idx; }

const Pk3Archives::Entry& Pk3Archives::entryOf(const std::string& name) const {
  const auto found = entries_.find(lowerCase(name));
  if (found == entries_.end()) throw InputError(path_, quoted(name), "a file of that name", "none");
  return found->second;
}

uint64_t Pk3Archives::sizeOf(const std::string& name) const {
  const Entry& entry = entryOf(name);
  const Archive& archive = *archives_[entry.archive_idx];
  zip_stat_t stat;
  if (zip_stat_index(archive.zip, entry.entry_idx, 0, &stat) != 0)
    throw InputError(archive.file, quoted(name), "a size", zip_strerror(archive.zip));
  return stat.size;
}

std::string Pk3Archives::read(const std::string& name, size_t max_bytes) const {
  const Entry& entry = entryOf(name);
  const Archive& archive = *archives_[entry.archive_idx];
  const auto fail = [&](const std::string& expected, const std::string& got) {
    throw InputError(archive.file, quoted(name), expected, got);
  };
  // what an entry claims is checked before memory is reserved for it
  zip_stat_t stat;
  if (zip_stat_index(archive.zip, entry.entry_idx, 0, &stat) != 0) fail("a size", zip_strerror(archive.zip));
  if (stat.encryption_method != ZIP_EM_NONE) fail("an entry that is not encrypted", "an encrypted one");
  if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE)
    fail("an entry that is stored or deflated", "method " + std::to_string(stat.comp_method));
  if (stat.size > max_bytes) fail("at most " + std::to_string(max_bytes) + " bytes", std::to_string(stat.size));
  // deflate gives at most 1032 bytes for one: what claims more is no file, and nothing is reserved for it
  if (stat.size / 1100 > stat.comp_size) fail("a size that its compressed bytes can hold", std::to_string(stat.size));
  unpacked_->take(stat.size, archive.file, quoted(name));

  const std::unique_ptr<zip_file_t, CloseFile> file(zip_fopen_index(archive.zip, entry.entry_idx, 0));
  if (file == nullptr) fail("a readable entry", zip_strerror(archive.zip));
  std::string bytes(stat.size, '\0');
  size_t done = 0;
  while (done < bytes.size()) {
    const zip_int64_t count = zip_fread(file.get(), bytes.data() + done, bytes.size() - done);
    if (count < 0) fail("whole compressed bytes", zip_file_strerror(file.get()));
    if (count == 0) fail("the " + std::to_string(stat.size) + " bytes that it declares", std::to_string(done));
    done += static_cast<size_t>(count);
  }
  // the read that meets the end compares the checksum
  char more = 0;
  const zip_int64_t count = zip_fread(file.get(), &more, 1);
  if (count < 0) fail("whole compressed bytes", zip_file_strerror(file.get()));
  if (count > 0) fail("the " + std::to_string(stat.size) + " bytes that it declares", "more");
  return bytes;
}

}  // namespace nlg
