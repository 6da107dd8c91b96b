// What happens to a process when a file that it has mapped into memory is shortened, or its disk fails.
#pragma once

#include <string>

namespace nlg {

// From now on SIGBUS, by which the system says that a mapped page is no longer there, ends the process with input_error and the one
// line "TOOL: error: PATH: ...", instead of killing it without a word. Whatever was saved before stays. Calls replace each other.
void endWhenPagesVanish(const std::string& tool, const std::string& path);

}  // namespace nlg
