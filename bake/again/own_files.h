// Recognises files of nlg-bake and nlg-view of any version, which these tools may overwrite (tool/output_path.h).
#pragma once

#include <string>
#include <vector>

#include "tool/output_path.h"

namespace nlg {

extern const OwnFiles kGridFiles, kKeptFiles, kReportFiles, kInputsFiles;

// What --inputs writes: names of files, sorted, as a list of JSON in one line. Of a name that is no UTF-8 each byte is a character, behind
// U+0001.
std::string inputsText(const std::vector<std::string>& paths);
// The inverse.
std::vector<std::string> inputsOf(const std::string& text);

}  // namespace nlg
