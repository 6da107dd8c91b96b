#include "scene/scene_file.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "runtime_eval/regular_file/regular_file.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {

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

bool isMissingBeside(const std::string& scene_path, const std::string& name) {
  const std::string path = folderOf(scene_path) + "/" + name;
  noteInput(path);
  std::error_code error;
  return fs::status(path, error).type() == fs::file_type::not_found;
}

std::string fileBeside(const std::string& scene_path, const std::string& name, const std::string& place) {
  const std::string folder = folderOf(scene_path);
  noteInput(folder + "/" + name);
  std::error_code error;
  const fs::path root = fs::weakly_canonical(folder, error);
  const fs::path file = error ? fs::path() : fs::weakly_canonical(folder + "/" + name, error);
  if (error) throw InputError(scene_path, place, "a file in the folder or below", error.message());
  const auto [root_end, file_end] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  if (root_end != root.end()) throw InputError(scene_path, place, "a file in the folder or below", "a link out of it");
  std::string fault;
  const int opened = openRegularFile(folder + "/" + name, &fault);
  if (opened < 0) throw notOpened(scene_path, place, fault);
  ::close(opened);
  return folder + "/" + name;
}

}  // namespace nlg
