#include "scene/archive/scene_file.h"

#include <unistd.h>
#include <utf8proc.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "runtime_eval/regular_file/regular_file.h"
#include "scene/archive/pk3_archive.h"
#include "scene/model/oddities.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {

void SceneBudget::require(uint64_t amount, const std::string& path, const std::string& place) const {
  if (amount <= left()) return;
  const uint64_t room = std::numeric_limits<uint64_t>::max() - taken_;
  throw BudgetError(path, place, fmt::format("at most {} {} in one scene", most_, what_),
                    std::to_string(taken_ + std::min(amount, room)));
}

void SceneBudget::take(uint64_t amount, const std::string& path, const std::string& place) {
  require(amount, path, place);
  taken_ += amount;
}

std::string sceneBudgets() {
  return fmt::format(
      "Limits of one scene. glTF or .obj file: {} triangles, {} bytes of files and of what they unpack to,\n"
      "{} elements of glTF accessors, {} of these without a buffer view. Quake III level: {} triangles.\n"
      "Archives: {} bytes unpacked. Textures: {} pixels, times their scans. A scene beyond them is refused;\n"
      "no known level comes near (docs/guide/scenes.md).",
      kMaxSceneTriangles, kMaxSceneBytes, kMaxAccessorElements, kMaxAccessorZeros, kMaxLevelTriangles, kMaxUnpackedBytes,
      kMaxImagePixels);
}

namespace fs = std::filesystem;

std::vector<unsigned char> readSceneFile(const std::string& path, const std::string& place, SceneBudget& bytes_left) {
  InputFile file(path, place);
  bytes_left.take(file.size(), path, place);
  std::vector<unsigned char> bytes(file.size());
  if (file.read(bytes.data(), bytes.size()) != bytes.size())
    throw InputError(path, place, std::to_string(bytes.size()) + " bytes, as when it was opened", "fewer");
  return bytes;
}

std::string folderOf(const std::string& path) {
  const std::string parent = fs::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

namespace {

// Neither of another machine nor outside of the folder.
bool isInside(const std::string& name) {
  const bool is_relative = !name.empty() && name[0] != '/' && name.find(':') == std::string::npos;
  return is_relative && !fs::path(name).lexically_normal().string().starts_with("..");
}

// A name by which all that differ in case, or in how accents are composed, are one. What is no UTF-8 is folded in ASCII alone.
std::string foldedName(const std::string& name) {
  constexpr auto kHow = static_cast<utf8proc_option_t>(UTF8PROC_COMPOSE | UTF8PROC_STABLE | UTF8PROC_CASEFOLD);
  utf8proc_uint8_t* folded = nullptr;
  const auto* bytes = reinterpret_cast<const utf8proc_uint8_t*>(name.data());
  const utf8proc_ssize_t size = utf8proc_map(bytes, static_cast<utf8proc_ssize_t>(name.size()), &folded, kHow);
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owned(folded, &std::free);
  return size < 0 ? lowerCase(name) : std::string(reinterpret_cast<const char*>(folded), static_cast<size_t>(size));
}

// The file of that name, or where there is none, of one that differs as foldedName lets it. Empty: none.
std::string nameOnDisk(const std::string& folder, const std::string& name) {
  int left = 4096;  // entries to look at
  std::error_code error;
  fs::path found;
  for (const fs::path& part : fs::path(name).lexically_normal()) {
    fs::path next = part;
    if (fs::symlink_status(folder / found / part, error).type() == fs::file_type::not_found) {
      for (fs::directory_iterator i(folder / found, error), end; !error && i != end && left > 0; i.increment(error), --left) {
        const fs::path other = i->path().filename();
        const bool is_same = foldedName(other.string()) == foldedName(part.string());
        if (is_same && (next == part || other < next)) next = other;
      }
      if (next == part) return {};
    }
    found /= next;
  }
  return found.string();
}

// As far as links of a folder may lead: to the top of the repository that it is in, since git-annex and DVC keep files in a store there,
// and links to them beside the scene; without one, the folder itself.
fs::path linkRoot(const fs::path& folder) {
  std::error_code error;
  for (fs::path top = folder; top != top.root_path(); top = top.parent_path()) {
    if (fs::exists(top / ".git", error) || fs::exists(top / ".dvc", error)) return top;
  }
  return folder;
}

// Whether a file lies in a store of git-annex (annex/objects/…/KEY/KEY, KEY: BACKEND-s123--DIGEST) or DVC (…/xx/DIGEST, the rest of it),
// wherever that is: of submodules, work trees and caches it is elsewhere. Named by its digest, it is known to whoever can name it.
bool isInStore(const fs::path& file) {
  const auto isDigest = [](const std::string& text) {
    return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
  };
  const std::string name = file.filename().string(), folder = file.parent_path().filename().string();
  const size_t key = name.find("--");
  if (key != std::string::npos)
    return folder == name && isDigest(name.substr(key + 2, 32)) && file.string().find("/annex/objects/") != std::string::npos;
  return folder.size() == 2 && isDigest(folder + name);
}

// Why a file in the folder cannot be opened; empty where it can.
std::string openProblem(const std::string& folder, const std::string& name) {
  std::error_code error;
  const fs::path root = linkRoot(fs::weakly_canonical(folder, error));
  const fs::path file = error ? fs::path() : fs::weakly_canonical(folder + "/" + name, error);
  std::string fault = error.message();
  if (!error) {
    fault = "a link out of it";
    const bool is_out = std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first != root.end();
    const int opened = is_out && !isInStore(file) ? -1 : openRegularFile(folder + "/" + name, &fault);
    if (opened >= 0) ::close(opened);
    if (opened >= 0) return {};
  }
  return "is no file in the scene's folder or below: " + fault;
}

FileBeside findIn(const std::string& folder, const std::string& address) {
  const std::string decoded = percentDecoded(address);
  if (address.empty() || std::any_of(decoded.begin(), decoded.end(), [](unsigned char c) { return c < 32; }))
    return {{}, "is no name of a file", {}};
  const std::string plain = withSlashes(decoded);
  const bool is_elsewhere = !isInside(plain);
  // as written, percent-decoded, and with slashes for backslashes
  std::vector<std::string> names;  // to try
  if (!is_elsewhere) names = {address, decoded, withSlashes(address), plain};
  // a path of another machine: its tails, longest first, are looked for beside the scene
  for (size_t at = plain.find('/'); is_elsewhere && at != std::string::npos; at = plain.find('/', at + 1))
    names.push_back(plain.substr(at + 1));
  std::vector<std::string> tried;
  for (size_t i = 0; i < names.size(); ++i) {
    if (!isInside(names[i]) || std::find(&names[0], &names[i], names[i]) != &names[i]) continue;
    noteInput(folder + "/" + names[i]);
    const std::string there = nameOnDisk(folder, names[i]);
    const std::string problem = there.empty() ? "" : openProblem(folder, there);
    if (!problem.empty()) return {{}, problem, {}};
    // a file under another name than the scene gives is reported
    const bool is_guess = is_elsewhere || there != fs::path(names[i]).lexically_normal().string();
    if (!there.empty()) return {folder + "/" + there, {}, is_guess ? there : ""};
    tried.push_back(names[i]);
  }
  const std::string problem = is_elsewhere ? "lies outside of the scene's folder and is not opened" : "is not there";
  const bool is_plain = tried.empty() || (tried.size() == 1 && tried[0] == address);
  return {{}, problem + (is_plain ? "" : " (tried " + listed(tried) + ")"), {}};
}

}  // namespace

FileBeside findBeside(const std::string& scene_path, const std::string& address) {
  const FileBeside found = findIn(folderOf(scene_path), address);
  std::error_code error;
  if (!found.path.empty() || !fs::is_symlink(scene_path, error)) return found;
  const FileBeside there = findIn(folderOf(fs::weakly_canonical(scene_path, error).string()), address);
  return there.path.empty() ? found : there;
}

std::string withSlashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

std::string percentDecoded(const std::string& text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    unsigned char code = 0;
    const bool is_code = text[i] == '%' && i + 2 < text.size() &&
                         std::from_chars(&text[i + 1], &text[i + 1] + 2, code, 16).ptr == &text[i + 1] + 2;
    decoded += is_code ? static_cast<char>(code) : text[i];
    if (is_code) i += 2;
  }
  return decoded;
}

}  // namespace nlg
