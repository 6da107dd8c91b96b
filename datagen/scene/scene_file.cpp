#include "datagen/scene/scene_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tool/error.h"

namespace nlg {

namespace fs = std::filesystem;

std::vector<unsigned char> readSceneFile(const std::string& path, const std::string& place) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw InputError(path, place, "a file", "nothing of that name");
  if (error || !fs::is_regular_file(status)) throw InputError(path, place, "a file", "something else");
  const uint64_t size = fs::file_size(path, error);
  if (error || size > kMaxSceneFileBytes)
    throw InputError(path, place, "less than 4 GiB", error ? error.message() : std::to_string(size));
  std::vector<unsigned char> bytes(size);
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!stream || static_cast<uint64_t>(stream.gcount()) != size)
    throw InputError(path, place, "a readable file", "a failed read");
  return bytes;
}

std::string folderOf(const std::string& path) {
  const std::string parent = fs::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

std::string fileBeside(const std::string& scene_path, const std::string& name, const std::string& place) {
  const std::string folder = folderOf(scene_path);
  const fs::path root = fs::weakly_canonical(folder);
  const fs::path file = fs::weakly_canonical(folder + "/" + name);
  const auto [root_end, file_end] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  if (root_end != root.end()) throw InputError(scene_path, place, "a file in the folder or below", "a link out of it");
  if (!fs::is_regular_file(file))
    throw InputError(scene_path, place, "a file", fs::exists(file) ? "something else" : "nothing of that name");
  return folder + "/" + name;
}

}  // namespace nlg
