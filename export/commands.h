// Commands of nlg-export that need no libtorch: describe weights, and convert light grids for shaders and engines.
#pragma once

#include <optional>

namespace nlg {

// A line of --help for each.
extern const char* const kCommands;

// Runs the command that the first argument names.
//
// returns   the process's exit code; nothing when the first argument is none of them
std::optional<int> runCommand(int argc, char** argv);

}  // namespace nlg
