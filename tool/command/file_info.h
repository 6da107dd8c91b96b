// The command `info` of every tool that writes files: verifies every byte of a file and describes it.
#pragma once

#include <functional>
#include <string>

#include <nlohmann/json.hpp>

namespace nlg {

struct FileInfoCommand {
  std::string tool;     // "nlg-pca info"
  std::string files;    // what they are called, for --help: "bases (.h5)"
  std::string section;  // the tool's own in pipeline.yaml
  // Verifies a file and says what it is; `origin` holds its provenance as an object, where it has one, and `verified` how much of
  // it is known to be whole.
  // throws   DamageError where the file's own bytes prove that it is damaged; other InputErrors where it is something else, or
  //          where the system does not give every byte
  std::function<nlohmann::ordered_json(const std::string& path)> describe;
};

// What `verified` says.
inline constexpr const char* kVerifiedByDigest = "every byte (SHA-256)";

// Runs the command: says of each file its path, what describe() gives, its size and SHA-256, as text or, with --json, as a line of
// JSON each; --quiet only verifies. Ends at the first file that does not hold: with ExitCode::damaged_file when it is proven
// damaged, so that the workflow may put it aside and make it again.
// argv      begins with the command's name
// returns   the process's exit code
int fileInfoMain(int argc, char** argv, const FileInfoCommand& command);

// A text of JSON as an object; what is no JSON as the text that it is.
nlohmann::ordered_json parsedOrText(const std::string& text);

}  // namespace nlg
