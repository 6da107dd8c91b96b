#include "train/generator/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr size_t kKeptCheckpoints = 2;

std::string nameOf(int64_t step) {
  // so many digits that names sort as steps do
  char name[32];
  std::snprintf(name, sizeof name, "step-%09lld.ckpt", static_cast<long long>(step));
  return name;
}

// Checkpoints of a folder, oldest first.
std::vector<fs::path> checkpoints(const std::string& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.rfind("step-", 0) == 0 && entry->path().extension() == ".ckpt") found.push_back(entry->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

void removeFile(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw OutputError(path.string(), error.message());
}

// A link cannot be overwritten, but renamed over.
void pointTo(const fs::path& link, const std::string& target) {
  const fs::path fresh = link.string() + ".tmp";
  ::unlink(fresh.c_str());
  if (::symlink(target.c_str(), fresh.c_str()) != 0 || ::rename(fresh.c_str(), link.c_str()) != 0) {
    throw OutputError(link.string(), std::generic_category().message(errno));
  }
}

}  // namespace

std::shared_ptr<void> RunFolder::lock() const {
  std::error_code error;
  fs::create_directories(path_, error);
  const std::string path = (fs::path(path_) / ".lock").string();
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file < 0) throw OutputError(path, std::generic_category().message(errno));
  // held by the open file: gone with the process, however it ends
  std::shared_ptr<void> held(nullptr, [file](void*) { ::close(file); });
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) throw UsageError("--run", "a folder that no other nlg-train uses", path_);
  return held;
}

std::vector<std::string> RunFolder::newestFirst() const {
  std::vector<std::string> paths;
  for (const fs::path& path : checkpoints(path_)) paths.insert(paths.begin(), path.string());
  return paths;
}

void RunFolder::writeOrigin(const nlohmann::ordered_json& config, const nlohmann::ordered_json& provenance) const {
  writeFileAtomically((fs::path(path_) / "config.json").string(), config.dump(2) + '\n');
  writeFileAtomically((fs::path(path_) / "provenance.json").string(), provenance.dump(2) + '\n');
}

void RunFolder::save(const RunIdentity& identity, const TrainingState& state) const {
  const std::string path = (fs::path(path_) / nameOf(state.step)).string();
  writeCheckpoint(path, identity, state);
  settle(path, state);
}

void RunFolder::settle(const std::string& checkpoint, const TrainingState& state) const {
  pointTo(fs::path(path_) / "latest", fs::path(checkpoint).filename().string());
  writeFileAtomically((fs::path(path_) / "log.csv").string(), state.log_csv);
  std::vector<fs::path> kept = checkpoints(path_);
  // later ones are damaged, or this would not be the newest: training writes them anew
  std::erase_if(kept, [&](const fs::path& path) { return path.filename() > fs::path(checkpoint).filename(); });
  for (size_t i = 0; i + kKeptCheckpoints < kept.size(); ++i) removeFile(kept[i]);
}

void RunFolder::clear() const {
  for (const char* name : {"latest", "log.csv"}) removeFile(fs::path(path_) / name);
  for (const fs::path& path : checkpoints(path_)) removeFile(path);
}

}  // namespace nlg
