// Turns a failed read of weights or a light grid into a tool's error.
#pragma once

#include <string>

#include "nlg/result.h"

namespace nlg {

// Returns when the file was read. Of one that names no digest it says so (sayUnchecked).
// expected   what the file should have been: "a light grid"
// throws     InputError with the result's status and detail; DamageError where the file's own bytes prove that it is damaged
void requireRead(const std::string& path, const FileResult& result, const std::string& expected);

// Says on stderr, once a process, that nobody knows whether a file is damaged.
// line   the file's path, and why
void sayUnchecked(const std::string& line);

}  // namespace nlg
