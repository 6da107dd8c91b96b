// The main function that all command-line tools share: common flags, and the one place that catches errors.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "tool/command/options.h"
#include "tool/error.h"

namespace CLI {
class App;
}

namespace nlg {

// Names the process that a tool is started by and ends with, however that ends: its id, in the environment.
inline constexpr const char* kEndsWith = "NLG_ENDS_WITH";

// Runs a tool: adds `--config FILE` and the table's flags to app, parses the command line, reads the tool's section of the
// file, applies the flags, then calls run(). Every exception ends here: one line on stderr, "nlg-pca: error: …", and the exit
// code of error.h (std::bad_alloc: internal_error, said as "out of memory"; other exceptions: internal_error).
// What is printed meanwhile on stderr, and on stdout where that is a terminal, holds no control characters but ends of lines and
// tabs: printable.h. SIGPIPE is ignored. Command-line mistakes exit with usage_error; --help, --help-all
// and --version with success; so do --list-options, by itself, which prints OptionTable::describeAsJson,
// and --list-flags, which prints all flags.
// The environment's NLG_INPUTS names a file for the names of all files that were read or looked for, if all went well (inputsText).
// returns   the process's exit code
int runTool(int argc, char** argv, CLI::App& app, OptionTable& table, const std::function<void()>& run);

// What a tool does when its first argument is this name.
struct Command {
  const char* name;
  int (*run)(int argc, char** argv);  // argv begins with the name
};
// returns   the exit code of the command that the first argument names; nothing when it names none
std::optional<int> runCommand(int argc, char** argv, std::span<const Command> commands);

}  // namespace nlg
