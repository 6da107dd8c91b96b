#include "tool/command/file_info.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>
#include <vector>

#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/printable.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

// A file's own texts may be anybody's.
std::string textOf(const Json& value) { return printable(value.is_string() ? value.get<std::string>() : value.dump()); }

void printForPeople(const Json& file) {
  for (const auto& [key, value] : file.items()) {
    if (key == "file") {
      std::cout << fmt::format("{}\n", textOf(value));
    } else if (key == "origin" && value.is_object()) {
      for (const auto& [name, part] : value.items()) std::cout << fmt::format("  {:<26}{}\n", printable(name), textOf(part));
    } else {
      std::cout << fmt::format("  {:<26}{}\n", key, textOf(value));
    }
  }
}

}  // namespace

Json parsedOrText(const std::string& text) {
  Json parsed = Json::parse(text, nullptr, false);
  return parsed.is_discarded() ? Json(text) : parsed;
}

int fileInfoMain(int argc, char** argv, const FileInfoCommand& command) {
  CLI::App app{"Verifies and describes " + command.files +
                   ". Stops at the first invalid file with one line and exit code 7 if its\n"
                   "own bytes prove that it is damaged, else 3 (unreadable, or of another kind or version).",
               command.tool};
  std::vector<std::string> paths;
  bool json = false, quiet = false;
  OptionTable table(command.section);
  app.add_option("files", paths, command.files)->required();
  app.add_flag("--json", json, "print one line of JSON per file");
  app.add_flag("--quiet", quiet, "print nothing about valid files");
  return runTool(argc, argv, app, table, [&] {
    for (const std::string& path : paths) {
      try {
        Json file = {{"file", path}};
        // describing reads the file to its end, and so verifies its digest
        file.update(command.describe(path));
        if (quiet) continue;
        file["bytes"] = std::filesystem::file_size(path);
        file["sha256"] = fileSha256(path);
        if (json)
          std::cout << file.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
        else
          printForPeople(file);
      } catch (const DamageError& error) {
        throw ToolError(ExitCode::damaged_file, error.what());
      }
    }
  });
}

}  // namespace nlg
