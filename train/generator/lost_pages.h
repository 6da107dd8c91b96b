// Turns the loss of a memory-mapped file's pages (file truncated, disk failure) into an error.
#pragma once

#include <string>

namespace nlg {

// From now on SIGBUS, by which the system says that a mapped page is no longer there, ends the process with input_error and the one
// line "TOOL: error: PATH: ...", instead of killing it without a word. Whatever was saved before stays. Calls replace each other.
void endWhenPagesVanish(const std::string& tool, const std::string& path);

}  // namespace nlg
