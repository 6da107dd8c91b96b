#include "tool/output_path.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tool/error.h"
#include "tool/printable.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

// Why nothing can be written into a folder; no error where something can.
std::error_code whyNotWritable(const std::string& folder) {
  std::error_code error;
  // made, since only that says whether it can be, and taken away again
  std::vector<fs::path> missing;
  for (fs::path path = fs::absolute(folder).lexically_normal(); !fs::exists(path, error) && path.has_relative_path();
       path = path.parent_path())
    missing.push_back(path);
  fs::create_directories(folder, error);
  if (!error && !fs::is_directory(folder)) error = std::make_error_code(std::errc::not_a_directory);
  if (!error && access(folder.c_str(), W_OK | X_OK) != 0) error = std::error_code(errno, std::generic_category());
  std::error_code kept;
  for (const fs::path& path : missing) fs::remove(path, kept);
  return error;
}

bool areInputs(std::string_view bytes) {
  const nlohmann::json list = nlohmann::json::parse(bytes, nullptr, false);
  return list.is_array() &&
         std::all_of(list.begin(), list.end(), [](const nlohmann::json& entry) { return entry.is_string(); }) &&
         std::is_sorted(list.begin(), list.end()) && list.dump() + "\n" == bytes;
}

}  // namespace

const OwnFiles kInputsFiles = {"a list of inputs", areInputs};

void refuseToReplaceInputs(const std::string& out, const std::vector<std::string>& inputs, const char* flag) {
  if (out.empty()) throw UsageError(flag, "the name of a file", "an empty text");
  if (out.ends_with('/')) throw UsageError(flag, "the name of a file", out + ", a folder");
  for (const std::string& input : inputs) {
    std::error_code error;
    if (fs::equivalent(out, input, error)) throw UsageError(flag, "a file that is not an input", out);
  }
}

bool mayReplace(const std::string& out, const OwnFiles& own) {
  std::error_code error;
  // what else there may be is for whoever writes to refuse
  if (!fs::is_regular_file(out, error)) return true;
  std::string bytes(std::min<uintmax_t>(fs::file_size(out, error), uintmax_t{16} << 20), '\0');
  std::ifstream(out, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return bytes.empty() || own.are(bytes);
}

void refuseToReplaceOthers(const std::string& out, const OwnFiles& own, const char* flag) {
  if (!mayReplace(out, own))
    throw UsageError(flag, std::string("a new file, or ") + own.name + " to overwrite", out + ", which is another kind of file");
}

void refuseToReplace(const std::string& out, const std::vector<std::string>& inputs, const OwnFiles& own, const char* flag) {
  refuseToReplaceInputs(out, inputs, flag);
  refuseToReplaceOthers(out, own, flag);
}

void requireOutputFolder(const std::string& out, const char* flag) {
  if (out.empty()) throw UsageError(flag, "the name of a folder", "an empty text");
  if (const std::error_code error = whyNotWritable(out)) throw OutputError(out, error.message());
}

void requireOutputFile(const std::string& out) {
  const fs::path path(out);
  std::error_code error;
  if (fs::is_directory(path, error)) {
    error = std::make_error_code(std::errc::is_a_directory);
  } else {
    error = whyNotWritable(path.has_parent_path() ? path.parent_path().string() : ".");
  }
  if (error) throw OutputError(out, error.message());
  if (path.has_parent_path() && !fs::exists(path.parent_path(), error))
    std::cerr << fmt::format("{}: the folder {} is not there yet, and will be made\n", program_invocation_short_name,
                             printable(path.parent_path().string()));
}

}  // namespace nlg
